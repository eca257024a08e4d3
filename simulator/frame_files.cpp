#include "simulator/frame_files.h"

#include <fmt/format.h>

#include <fstream>

#include "core/base/files.h"
#include "simulator/noise/depth_noise.h"
#include "simulator/noise/image_noise.h"
#include "simulator/noise/segmenter.h"
#include "simulator/png.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kMaxUnits = 65535;  // 16 bits

fs::path marker(const fs::path& folder, std::int64_t frame) {
  return folder / "frames" / fmt::format("{:06}.csv", frame);
}

std::string visibility_rows(const Scene& scene, std::int64_t frame, const std::vector<ObjectView>& views) {
  std::string rows;
  for (const ObjectView& view : views)
    rows += fmt::format("{},{},{},{},{},{},{}\n", frame, scene.stamp_ns(frame), view.id, view.visible_px,
                        view.silhouette_px, view.visible_fraction(), view.touches_border ? 1 : 0);
  return rows;
}

cv::Mat encode_depth(const cv::Mat& depth_m, double units_per_m) {
  cv::Mat encoded;
  depth_m.convertTo(encoded, CV_16U, units_per_m);
  return encoded;
}

}  // namespace

void create_frame_folders(const fs::path& folder) {
  for (const char* name : {"frames", "sequence/rgb", "sequence/depth", "sequence/masks", "truth/instances"})
    fs::create_directories(folder / name);
}

bool is_frame_complete(const fs::path& folder, std::int64_t frame) {
  return fs::exists(marker(folder, frame));
}

void write_frame(const Scene& scene, std::uint64_t seed, const fs::path& folder, std::int64_t frame,
                 const RenderedFrame& rendered) {
  const std::string file = fmt::format("{:06}.png", frame);
  const fs::path sequence = folder / "sequence";
  write_png(sequence / "rgb" / file, add_image_noise(rendered.rgb, scene.image_noise, seed, frame),
            PngPacking::stored);
  const cv::Mat depth_m = add_depth_noise(rendered.depth_m, scene.camera, scene.depth_noise, seed, frame);
  write_png(sequence / "depth" / file, encode_depth(depth_m, depth_units_per_m(scene.depth_noise)),
            PngPacking::stored);
  if (is_segmented(scene.segmenter, frame))
    write_png(sequence / "masks" / file, segment(rendered.ids, scene.segmenter, seed, frame),
              PngPacking::packed);
  write_png(folder / "truth/instances" / file, rendered.ids, PngPacking::packed);
  write_text(marker(folder, frame), visibility_rows(scene, frame, rendered.objects));
}

void join_visibility(const fs::path& folder, std::int64_t frames) {
  const fs::path path = folder / "truth/instances/visibility.csv";
  std::ofstream out(path, std::ios::binary);
  out << "frame,timestamp_ns,id,visible_px,silhouette_px,visible_fraction,touches_border\n";
  for (std::int64_t frame = 0; frame < frames; ++frame) out << read_text(marker(folder, frame));
  out.close();
  if (!out) throw std::runtime_error(fmt::format("{}: cannot be written", path.string()));
}

double depth_units_per_m(const DepthNoise& noise) {
  for (const double units : {5000.0, 1000.0})  // TUM RGB-D, and most others
    if (noise.max_range_m * units <= kMaxUnits) return units;
  return 256;  // KITTI
}

}  // namespace uniquadric
