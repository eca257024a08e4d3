#pragma once

#include <cstdint>
#include <filesystem>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Time of a frame: its stamp, so that poses belong to the stamps as they are written.
double frame_time_s(const Scene& scene, std::int64_t frame);

/// Writes what a sequence folder holds beside its images: sequence.yaml, the file lists, camera_given.tum.
void write_sequence_files(const Scene& scene, std::uint64_t seed, std::int64_t frames,
                          const std::filesystem::path& folder);

/// Writes what a truth folder holds beside its images: camera.tum, camera.yaml, objects/ID.tum,
/// objects/ID.ply (its mesh), objects.yaml, map.bt.
void write_truth_files(const Scene& scene, std::int64_t frames, const std::filesystem::path& folder);

}  // namespace uniquadric
