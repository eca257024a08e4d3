#pragma once

#include <filesystem>
#include <optional>

#include "core/sequence/ply.h"
#include "evaluation/object_evaluation.h"

namespace uniquadric {

/// The mesh truth/objects/ID.ply of an object in its frame; nothing without that file. Throws InputError for
/// a file that cannot be read or has no faces.
std::optional<SurfaceFile> true_surface_of_file(const std::filesystem::path& truth,
                                                const ObjectDescription& object);

/// The true surface of an object in its frame: truth/objects/ID.ply, else of a `box` that of its sides;
/// nothing of others. Throws InputError for a file that cannot be read or has no faces.
std::optional<SurfaceFile> true_surface(const std::filesystem::path& truth, const ObjectDescription& object);

/// The points that the estimate keeps of the matched track (ESTIMATE/objects/ID.ply, in the frame of its
/// states); nothing without points or a match.
std::optional<SurfaceFile> kept_points(const std::filesystem::path& estimate, const ObjectEvaluation& object);

}  // namespace uniquadric
