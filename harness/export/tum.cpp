// The layout of the TUM RGB-D benchmark (Sturm et al., IROS 2012; cvg.cit.tum.de/data/datasets/rgbd-dataset/
// file_formats): stamps in seconds, depth 5000 a metre, world_from_camera as tx ty tz qx qy qz qw.
#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kTumUnitsPerM = 5000;

// Depth in the format's unit; what does not fit into 16 bits (13.1 m and beyond) becomes "none".
void write_depth(const Sequence& sequence, const SequenceFrame& frame, const fs::path& path) {
  const cv::Mat depth_m = read_depth(sequence, frame);
  if (sequence.depth_units_per_m == kTumUnitsPerM && frame.depth.extension() == ".png") {
    duplicate_file(sequence.folder / frame.depth, path);
    return;
  }
  cv::Mat units;
  depth_m.convertTo(units, CV_32F, kTumUnitsPerM);
  units.setTo(0, units > std::numeric_limits<std::uint16_t>::max());
  units.convertTo(units, CV_16U);
  write_png(path, units);
}

std::string list_header(const char* what, const Sequence& sequence) {
  return fmt::format("# {}\n# file: '{}'\n# timestamp filename\n", what, sequence.name);
}

}  // namespace

void write_tum_recording(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  require_images(sequence, "export tum");
  for (const char* name : {"rgb", "depth"}) fs::create_directories(folder / name);
  std::string rgb = list_header("color images", sequence), depth = list_header("depth maps", sequence);
  Progress progress("export tum", std::ssize(sequence.frames), options.quiet);
  for (const SequenceFrame& frame : sequence.frames) {
    const std::string stamp = format_stamp(frame.stamp_ns);
    write_color_png(source, frame, false, folder / fmt::format("rgb/{}.png", stamp));
    rgb += fmt::format("{0} rgb/{0}.png\n", stamp);
    if (!frame.depth.empty()) {
      write_depth(sequence, frame, folder / fmt::format("depth/{}.png", stamp));
      depth += fmt::format("{0} depth/{0}.png\n", stamp);
    }
    progress.advance();
  }
  write_text(folder / "rgb.txt", rgb);
  write_text(folder / "depth.txt", depth);
  if (const Trajectory poses = camera_poses(source); !poses.empty())
    write_tum(folder / "groundtruth.txt", poses);
  write_text(folder / "camera.yaml",
             fmt::format("{{{}, depth_units_per_metre: {}}}\n", camera_yaml(sequence.camera), kTumUnitsPerM));
}

}  // namespace uniquadric
