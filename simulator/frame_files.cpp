#include "simulator/frame_files.h"

#include <fmt/format.h>

#include <cstring>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "simulator/noise/depth_noise.h"
#include "simulator/noise/exposure.h"
#include "simulator/noise/segmenter.h"
#include "simulator/scene_files.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kMaxUnits = 65535;  // 16 bits

// Drops the fourth channel. A pixel is copied with the byte behind it, which the next one overwrites.
void pack_rgb(const unsigned char* rgba, int count, unsigned char* rgb) {
  for (int u = 0; u + 1 < count; ++u) std::memcpy(rgb + 3 * u, rgba + 4 * u, 4);
  std::memcpy(rgb + 3 * (count - 1), rgba + 4 * (count - 1), 3);
}

void pack_16_bits(const std::uint16_t* values, int count, unsigned char* out) {
  for (int u = 0; u < count; ++u) {
    const auto swapped = static_cast<std::uint16_t>(values[u] >> 8 | values[u] << 8);
    std::memcpy(out + 2 * u, &swapped, 2);
  }
}

}  // namespace

void create_frame_folders(const Scene& scene, const fs::path& folder) {
  for (const char* name : {"sequence/rgb", "sequence/masks", "truth/instances"})
    fs::create_directories(folder / name);
  if (scene.depth) fs::create_directories(folder / "sequence/depth");
}

FrameWriter::FrameWriter(const Scene& scene, std::uint64_t seed, fs::path folder)
    : scene_(scene),
      seed_(seed),
      folder_(std::move(folder)),
      rays_(scene.camera),
      image_noise_(scene.image_noise, seed),
      color_(PngFormat::rgb_8, scene.camera.width, scene.camera.height),
      depth_(PngFormat::grey_16, scene.camera.width, scene.camera.height) {
  for (const Body& body : scene.objects) objects_.insert(body.id);
}

bool FrameWriter::write(std::int64_t frame, const RenderedFrame& rendered, LapTimer& timer) {
  const std::string file = fmt::format("{:06}.png", frame);
  const auto put = [&](const char* part, std::string_view bytes, FrameStage stage) {
    timer.lap(stage);
    write_file(folder_ / part / file, bytes);
    timer.lap(FrameStage::write);
  };
  fill_color(frame, exposed(rendered.rgba, scene_.imaging, seed_, frame_time_s(scene_, frame)));
  put("sequence/rgb", color_.finish(), FrameStage::color);
  bool is_whole = true;
  if (scene_.depth) {
    is_whole = fill_depth(frame, rendered);
    put("sequence/depth", depth_.finish(), FrameStage::depth);
  }
  if (is_segmented(scene_.segmenter, seed_, frame, scene_.rate_hz))
    put("sequence/masks",
        pack_png(segment(rendered.ids, scene_.segmenter, seed_, frame, scene_.rate_hz, objects_)),
        FrameStage::masks);
  put("truth/instances", pack_png(rendered.ids), FrameStage::masks);
  return is_whole;
}

void FrameWriter::fill_color(std::int64_t frame, const cv::Mat& rgba) {
  for (int v = 0; v < rgba.rows; ++v) {
    unsigned char* row = color_.row(v);
    pack_rgb(rgba.ptr(v), rgba.cols, row);
    image_noise_.add_to_row(frame, v, {row, 3 * static_cast<std::size_t>(rgba.cols)});
  }
}

bool FrameWriter::fill_depth(std::int64_t frame, const RenderedFrame& rendered) {
  const cv::Mat& rgba = rendered.returning_rgba.empty() ? rendered.rgba : rendered.returning_rgba;
  const cv::Mat noisy_m = add_depth_noise(rendered.depth_m, rgba, rays_, scene_.depth_noise, seed_, frame);
  cv::Mat units;
  noisy_m.convertTo(units, CV_16U, depth_units_per_m(scene_.depth_noise));
  for (int v = 0; v < units.rows; ++v) pack_16_bits(units.ptr<std::uint16_t>(v), units.cols, depth_.row(v));
  return cv::countNonZero(units) > 0;
}

std::string visibility_lines(const Scene& scene, std::int64_t frame, const RenderedFrame& rendered) {
  std::string lines;
  for (const ObjectView& view : rendered.objects)
    lines += fmt::format("{},{},{},{},{},{},{}\n", frame, scene.stamp_ns(frame), view.id, view.visible_px,
                         view.silhouette_px, view.visible_fraction(), view.touches_border ? 1 : 0);
  return lines;
}

void write_visibility(const fs::path& folder, const std::string& lines) {
  write_text(folder / "truth/instances/visibility.csv",
             "frame,timestamp_ns,id,visible_px,silhouette_px,visible_fraction,touches_border\n" + lines);
}

double depth_units_per_m(const DepthNoise& noise) {
  for (const double units : {5000.0, 1000.0})  // TUM RGB-D, and most others
    if (noise.max_range_m * units <= kMaxUnits) return units;
  return 256;  // KITTI
}

}  // namespace uniquadric
