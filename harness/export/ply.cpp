// Point clouds as PLY, binary little-endian (Turk, "The PLY polygon file format", 1994).
#include <fmt/format.h>

#include <bit>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/sequence/ply.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "values are written as they lie in memory");

template <typename... T>
void put(std::string& data, T... values) {
  (data.append(reinterpret_cast<const char*>(&values), sizeof values), ...);
}

std::string vertices(std::size_t count, const char* properties) {
  return fmt::format("element vertex {}\n{}", count, properties);
}

constexpr const char* kDepthProperties =
    "property float x\nproperty float y\nproperty float z\nproperty uchar red\nproperty uchar green\n"
    "property uchar blue\nproperty ushort instance\n";
constexpr std::size_t kDepthPointSize = 3 * 4 + 3 + 2;

void add_depth_points(const ExportSource& source, const SequenceFrame& frame, const Pose& world_from_camera,
                      int stride, std::string& data) {
  const Camera& camera = source.sequence.camera;
  const cv::Mat color = read_rgb(source.sequence, frame), depth_m = read_depth(source.sequence, frame);
  const cv::Mat ids = source.truth ? read_instances(source, frame) : cv::Mat::zeros(depth_m.size(), CV_16UC1);
  for (int v = 0; v < depth_m.rows; v += stride)
    for (int u = 0; u < depth_m.cols; u += stride) {
      const double z_m = depth_m.at<float>(v, u);
      const auto ray = z_m > 0 ? camera.unproject(Eigen::Vector2d(u, v)) : std::nullopt;
      if (!ray) continue;
      const Eigen::Vector3f p = (world_from_camera * (z_m * *ray).eval()).cast<float>();
      const auto& bgr = color.at<cv::Vec3b>(v, u);
      put(data, p.x(), p.y(), p.z(), bgr[2], bgr[1], bgr[0], ids.at<std::uint16_t>(v, u));
    }
}

void write_fused_depth(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  std::string data;
  const auto& frames = source.sequence.frames;
  Progress progress("export ply: depth", std::ssize(frames), options.quiet);
  for (const SequenceFrame& frame : frames) {
    progress.advance();
    const auto pose = camera_pose(source, frame);
    if (frame.depth.empty() || !pose || frame.frame % options.frame_stride != 0) continue;
    add_depth_points(source, frame, *pose, options.pixel_stride, data);
  }
  if (data.empty()) return;
  write_ply(folder / "depth.ply",
            fmt::format("{}: every {}. depth image, world frame, metres", source.sequence.name,
                        options.frame_stride),
            vertices(data.size() / kDepthPointSize, kDepthProperties), data);
}

constexpr const char* kScanProperties =
    "property float x\nproperty float y\nproperty float z\nproperty float intensity\n"
    "property uint offset_ns\nproperty ushort ring\nproperty uchar tag\n";
constexpr std::size_t kScanPointSize = 4 * 4 + 4 + 2 + 1;

void write_scans(const Sequence& sequence, const ExportOptions& options, const fs::path& folder) {
  fs::create_directories(folder);
  Progress progress("export ply: scans", std::ssize(sequence.scans), options.quiet);
  for (std::size_t i = 0; i < sequence.scans.size(); ++i) {
    const SequenceScan& scan = sequence.scans[i];
    std::string data;
    for (const LidarPoint& p : read_lidar_points(sequence.folder / scan.file))
      put(data, p.x, p.y, p.z, p.intensity, p.offset_ns, p.ring, p.tag);
    write_ply(
        folder / fmt::format("{:06}.ply", i),
        fmt::format("{}: scan from {} s on, lidar frame, metres", sequence.name, format_stamp(scan.stamp_ns)),
        vertices(data.size() / kScanPointSize, kScanProperties), data);
    progress.advance();
  }
}

}  // namespace

void write_ply_clouds(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  if (options.frame_stride < 1 || options.pixel_stride < 1)
    throw InputError("export ply: a stride must be at least 1");
  write_fused_depth(source, options, folder);
  if (source.sequence.lidar) write_scans(source.sequence, options, folder / "lidar");
  if (!source.sequence.lidar && !fs::exists(folder / "depth.ply"))
    throw InputError(source.sequence.folder, "has neither LiDAR scans nor depth images with camera poses");
}

}  // namespace uniquadric
