#pragma once

#include <cstdint>
#include <filesystem>
#include <set>
#include <string>

#include "simulator/noise/image_noise.h"
#include "simulator/noise/pixel_rays.h"
#include "simulator/png.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/scene.h"
#include "simulator/stage_times.h"

namespace uniquadric {

/// Makes the folders that the images of all frames go to, below `folder`.
void create_frame_folders(const Scene& scene, const std::filesystem::path& folder);

/// Adds the sensors' errors to rendered frames and writes their images: sequence/{rgb,depth,masks} as
/// measured, truth/instances exact. For one thread; what it writes depends on the frame alone.
class FrameWriter {
 public:
  FrameWriter(const Scene& scene, std::uint64_t seed, std::filesystem::path folder);
  /// Whether the depth image has a valid pixel; true where the camera measures no depth.
  bool write(std::int64_t frame, const RenderedFrame& rendered, LapTimer& timer);

 private:
  void fill_color(std::int64_t frame, const cv::Mat& rgba);
  bool fill_depth(std::int64_t frame, const RenderedFrame& rendered);

  const Scene& scene_;
  std::uint64_t seed_;
  std::set<int> objects_;  // their ids
  std::filesystem::path folder_;
  PixelRays rays_;
  ImageNoiseSource image_noise_;
  StoredPng color_, depth_;
};

/// The frame's lines of truth/instances/visibility.csv, one an object.
std::string visibility_lines(const Scene& scene, std::int64_t frame, const RenderedFrame& rendered);

/// Writes truth/instances/visibility.csv: frame, timestamp_ns, id, visible_px, silhouette_px,
/// visible_fraction, touches_border (0, 1; ObjectView), a line for each object and frame.
void write_visibility(const std::filesystem::path& folder, const std::string& lines);

/// Value of a depth pixel at 1 m: TUM's 5000 when max_range_m fits into 16 bits so (13.1 m), else 1000, else
/// 256.
double depth_units_per_m(const DepthNoise& noise);

}  // namespace uniquadric
