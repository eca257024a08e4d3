#pragma once

#include <filesystem>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// The name that a folder's only trajectory of the camera has, as programs write it in TUM text: camera.tum,
/// trajectory.txt, CameraTrajectory.txt or KeyFrameTrajectory.txt; empty where it has none. Throws InputError
/// where it has several.
std::filesystem::path camera_file(const std::filesystem::path& folder);

/// A result in TUM text: a trajectory (world_from_camera), or a folder with one (camera_file) and,
/// optionally, objects/ID.tum or objects/ID.txt (world_from_object) with their sizes in objects.yaml. Stamps
/// are taken as they are, frames are counted by them. Throws InputError with file and line.
Tracks read_tum_result(const std::filesystem::path& source);

}  // namespace uniquadric
