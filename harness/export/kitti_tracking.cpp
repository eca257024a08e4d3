// The layout of KITTI's tracking benchmark (Geiger et al., CVPR 2012; devkit_tracking/readme.txt).
#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/import/kitti_files.h"
#include "core/import/rectify.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/kitti_label.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kScanSlackNs = 1000;  // ours: for stamps and periods that were rounded
constexpr double kFullIntensity = 255;       // of a point; KITTI's reflectance is from 0 to 1

std::string rows_of(const Pose& pose) {
  std::string text;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column) text += fmt::format(" {:.16e}", pose.matrix()(row, column));
  return text.substr(1);
}

std::string calibration_text(const Sequence& sequence) {
  const Camera& camera = sequence.camera;
  std::string text;
  for (int i = 0; i < 4; ++i)
    text += fmt::format("P{}: {:.16e} 0 {:.16e} 0 0 {:.16e} {:.16e} 0 0 0 1 0\n", i, camera.fx, camera.cx,
                        camera.fy, camera.cy);
  const Pose camera_from_velodyne =
      sequence.lidar ? sequence.lidar->camera_from_lidar : camera_from_velodyne_axes();
  text += "R_rect 1 0 0 0 1 0 0 0 1\n";
  text += "Tr_velo_cam " + rows_of(camera_from_velodyne) + "\n";
  const Pose camera_from_imu = sequence.imu ? sequence.imu->camera_from_imu : camera_from_velodyne;
  text += "Tr_imu_velo " + rows_of(camera_from_velodyne.inverse() * camera_from_imu) + "\n";
  return text;
}

// The scan that was being taken at a time: its middle is nearest, half a scan away at most.
const SequenceScan* scan_near(const Sequence& sequence, std::int64_t stamp_ns) {
  if (!sequence.lidar) return nullptr;
  const std::int64_t period_ns = std::llround(1e9 / sequence.lidar->rate_hz);
  const SequenceScan* nearest = nullptr;
  std::int64_t least_ns = period_ns / 2 + kScanSlackNs;
  for (const SequenceScan& scan : sequence.scans) {
    const std::int64_t distance_ns = std::abs(scan.stamp_ns + period_ns / 2 - stamp_ns);
    if (distance_ns < least_ns) nearest = &scan, least_ns = distance_ns;
  }
  return nearest;
}

// A frame of KITTI, with an image or a scan at least.
struct KittiFrame {
  SequenceFrame frame;
  const SequenceScan* scan = nullptr;
};

// The sequence's; of a LiDAR alone its scans, each a frame at its end, where the import looks for it.
std::vector<KittiFrame> frames_of(const Sequence& sequence) {
  std::vector<KittiFrame> frames;
  for (const SequenceFrame& frame : sequence.frames)
    frames.push_back({frame, scan_near(sequence, frame.stamp_ns)});
  if (!frames.empty()) return frames;
  const std::int64_t period_ns = std::llround(1e9 / sequence.lidar->rate_hz);
  for (const SequenceScan& scan : sequence.scans) {
    KittiFrame& frame = frames.emplace_back();
    frame.frame.frame = std::ssize(frames) - 1;
    frame.frame.stamp_ns = scan.stamp_ns + period_ns;
    frame.scan = &scan;
  }
  return frames;
}

void write_velodyne(const Sequence& sequence, const SequenceScan& scan, const fs::path& path) {
  std::string bytes;
  for (const LidarPoint& point : read_lidar_points(sequence.folder / scan.file))
    for (const float value :
         {point.x, point.y, point.z, static_cast<float>(point.intensity / kFullIntensity)})
      bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
  write_text(path, bytes);
}

std::string label_lines(const ExportSource& source, const SequenceFrame& frame) {
  if (!source.truth) return "";
  const cv::Mat ids = rectify(source.sequence.camera, read_instances(source, frame), false);
  std::string lines;
  for (const ObjectAtFrame& object : objects_at(source, frame))
    if (const auto box = box_of_id(ids, object.object->id))
      lines += kitti_label_line(source.sequence.camera, frame.frame, object, *box);
  return lines;
}

// KITTI odometry's poses: first_camera_from_camera. The format has no gaps: nothing unless every frame has
// one.
std::string poses_text(const ExportSource& source, const std::vector<KittiFrame>& frames) {
  std::vector<Pose> poses;
  for (const KittiFrame& kitti : frames)
    if (const auto pose = camera_pose(source, kitti.frame)) poses.push_back(*pose);
  if (poses.size() != frames.size()) return "";
  std::string text;
  for (const Pose& pose : poses) text += rows_of(poses.front().inverse() * pose) + "\n";
  return text;
}

}  // namespace

void write_kitti_tracking(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  const bool has_images = !sequence.frames.empty();
  const auto make_folder = [&](const char* name) { fs::create_directories(folder / name); };
  for (const char* name : {"calib", "times", "poses"}) make_folder(name);
  for (const char* name : {"image_02/0000", "label_02"})
    if (has_images) make_folder(name);
  if (sequence.lidar) make_folder("velodyne/0000");
  const std::vector<KittiFrame> frames = frames_of(sequence);
  std::string labels, times;
  Progress progress("export kitti-tracking", std::ssize(frames), options.quiet);
  for (const auto& [frame, scan] : frames) {
    if (has_images)
      write_color_png(source, frame, true, folder / fmt::format("image_02/0000/{:06}.png", frame.frame));
    if (scan) write_velodyne(sequence, *scan, folder / fmt::format("velodyne/0000/{:06}.bin", frame.frame));
    if (has_images) labels += label_lines(source, frame);
    times += format_stamp(frame.stamp_ns) + "\n";
    progress.advance();
  }
  write_text(folder / "calib/0000.txt", calibration_text(sequence));
  write_text(folder / "times/0000.txt", times);
  if (source.truth && has_images) write_text(folder / "label_02/0000.txt", labels);
  if (const std::string poses = poses_text(source, frames); !poses.empty())
    write_text(folder / "poses/0000.txt", poses);
}

}  // namespace uniquadric
