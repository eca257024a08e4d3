#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include "evaluation/metrics/surface_error.h"
#include "evaluation/object_evaluation.h"

namespace uniquadric {

/// The true surface of an object in its frame: truth/objects/ID.ply, else of a `box` that of its sides;
/// nothing of others. Throws InputError for a file that cannot be read or has no faces.
std::optional<SurfaceFile> true_surface(const std::filesystem::path& truth, const ObjectDescription& object);

/// Compares the points of the matched track (ESTIMATE/objects/ID.ply, in the frame of its states) with the
/// true surface. Their frames are laid on one another once for the whole track, where its poses usually have
/// them (usual_body_offset): what the poses are off by frame by frame is APE's to say. `scale` is that of the
/// world's alignment. Nothing without points, a true surface or a match.
std::optional<SurfaceError> evaluate_surface(const std::filesystem::path& truth,
                                             const std::filesystem::path& estimate,
                                             const ObjectDescription& description,
                                             const ObjectEvaluation& object, double scale);

}  // namespace uniquadric
