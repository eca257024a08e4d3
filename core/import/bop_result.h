#pragma once

#include <filesystem>

#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"

namespace uniquadric {

/// A result in the CSV of the BOP challenge, `scene_id,im_id,obj_id,score,R,t,time` of one scene: R row by
/// row, t in millimetres, camera_from_model; im_id counts the sequence's frames. `source` is the file, or a
/// folder with one .csv. Sizes are those of models_info.json or models/models_info.json beside it, else of
/// objects.yaml; the object's frame is the centre of its box. The camera's poses are those of
/// scene_camera.json beside it where it has any, else those of camera.tum (camera_of_result). Of several
/// instances of an object in an image that of the best score is taken, the others are counted by a warning.
/// Throws InputError with file and line.
Tracks read_bop_result(const std::filesystem::path& source, const Sequence& sequence);

}  // namespace uniquadric
