#pragma once

#include <cstdint>
#include <filesystem>

#include "simulator/render/renderer.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// Makes the folders that the images of all frames go to, below `folder`.
void create_frame_folders(const std::filesystem::path& folder);

/// Adds the sensors' errors to a rendered frame and writes its images: sequence/{rgb,depth,masks} as
/// measured, truth/instances exact. A last small file (how much of each object is visible) marks the frame as
/// complete.
void write_frame(const Scene& scene, std::uint64_t seed, const std::filesystem::path& folder,
                 std::int64_t frame, const RenderedFrame& rendered);

/// Whether write_frame() went through for this frame.
bool is_frame_complete(const std::filesystem::path& folder, std::int64_t frame);

/// Joins the frames' last files to truth/instances/visibility.csv: frame, timestamp_ns, id, visible_px,
/// silhouette_px, visible_fraction, touches_border (0, 1; ObjectView), a line for each object and frame.
void join_visibility(const std::filesystem::path& folder, std::int64_t frames);

/// Value of a depth pixel at 1 m: TUM's 5000 when max_range_m fits into 16 bits so (13.1 m), else 1000, else
/// 256.
double depth_units_per_m(const DepthNoise& noise);

}  // namespace uniquadric
