// A ROS 1 bag with the topics that visual, LiDAR and inertial odometry read. Topics and frames:
// docs/export.md.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"
#include "harness/rosbag/bag_writer.h"

namespace uniquadric {
namespace {

constexpr std::int64_t kLeastStampNs = 1'000'000'000;  // ours: ROS takes a time of 0 for "no time"
constexpr const char* kCameraFrame = "camera_optical";

// What is written at one time.
struct BagEvent {
  std::int64_t record_ns = 0;
  std::function<void()> write;
};

class BagExport {
 public:
  BagExport(const ExportSource& source, const std::filesystem::path& path)
      : source_(source), sequence_(source.sequence), bag_(path) {
    if (sequence_.imu) imu_ = read_imu_csv(sequence_.folder / "imu.csv");
    const std::int64_t first_ns = first_stamp_ns();
    shift_ns_ = std::max<std::int64_t>(0, kLeastStampNs - first_ns);
    add_events();
    write_static_transforms(first_ns + shift_ns_);
  }

  void write(bool quiet) {
    std::stable_sort(events_.begin(), events_.end(),
                     [](const BagEvent& a, const BagEvent& b) { return a.record_ns < b.record_ns; });
    Progress progress("export rosbag", std::ssize(events_), quiet);
    for (const BagEvent& event : events_) {
      event.write();
      progress.advance();
    }
    bag_.close();
  }

 private:
  // Of all sensors; every sequence has frames or scans.
  std::int64_t first_stamp_ns() const {
    std::int64_t first_ns = std::numeric_limits<std::int64_t>::max();
    const auto look = [&](const auto& list) {
      if (!list.empty()) first_ns = std::min(first_ns, list.front().stamp_ns);
    };
    look(sequence_.frames);
    look(sequence_.scans);
    look(imu_);
    return first_ns;
  }

  void add_events() {
    for (const ImuSample& sample : imu_)
      events_.push_back({sample.stamp_ns,
                         [&] { bag_.imu("/imu", header(sample.stamp_ns, "imu"), sample, *sequence_.imu); }});
    for (const SequenceFrame& frame : sequence_.frames)
      events_.push_back({frame.stamp_ns, [&] { write_frame(frame); }});
    if (!sequence_.lidar) return;
    const std::int64_t scan_ns = std::llround(1e9 / sequence_.lidar->rate_hz);
    for (const SequenceScan& scan : sequence_.scans)  // a driver sends a scan when it is over
      events_.push_back({scan.stamp_ns + scan_ns,
                         [this, &scan, scan_ns] { write_scan(scan, scan.stamp_ns + scan_ns + shift_ns_); }});
  }

  BagHeader header(std::int64_t stamp_ns, const char* frame) const { return {stamp_ns + shift_ns_, frame}; }

  void write_static_transforms(std::int64_t stamp_ns) {
    std::vector<BagTransform> transforms;
    if (sequence_.imu) transforms.push_back({kCameraFrame, "imu", sequence_.imu->camera_from_imu});
    if (sequence_.lidar) transforms.push_back({kCameraFrame, "lidar", sequence_.lidar->camera_from_lidar});
    if (!transforms.empty()) bag_.static_transforms(stamp_ns, transforms);
  }

  void write_frame(const SequenceFrame& frame) {
    const BagHeader camera = header(frame.stamp_ns, kCameraFrame), world = header(frame.stamp_ns, "world");
    bag_.image("/camera/rgb/image_raw", camera, read_rgb(sequence_, frame));
    bag_.camera_info("/camera/rgb/camera_info", camera, sequence_.camera);
    if (!frame.depth.empty()) {
      cv::Mat depth_m = read_depth(sequence_, frame);
      depth_m.setTo(std::numeric_limits<float>::quiet_NaN(), depth_m == 0);  // REP 118: none
      bag_.image("/camera/depth/image_raw", camera, depth_m);
      bag_.camera_info("/camera/depth/camera_info", camera, sequence_.camera);
    }
    const auto pose = camera_pose(source_, frame);
    if (pose) bag_.pose("/truth/camera", world, *pose);
    for (const ObjectAtFrame& object : objects_at(source_, frame))
      bag_.pose(fmt::format("/truth/object_{}", object.object->id), world, *pose * object.camera_from_object);
  }

  void write_scan(const SequenceScan& scan, std::int64_t record_ns) {
    const auto points = read_lidar_points(sequence_.folder / scan.file);
    bag_.point_cloud("/lidar/points", header(scan.stamp_ns, "lidar"), record_ns, points);
    bag_.livox("/livox/lidar", header(scan.stamp_ns, "lidar"), record_ns, points);
  }

  const ExportSource& source_;
  const Sequence& sequence_;
  std::vector<ImuSample> imu_;
  std::vector<BagEvent> events_;
  std::int64_t shift_ns_ = 0;
  BagWriter bag_;
};

}  // namespace

void write_rosbag(const ExportSource& source, const ExportOptions& options,
                  const std::filesystem::path& folder) {
  const std::filesystem::path bag = folder / (source.sequence.name + ".bag");
  try {
    BagExport(source, bag).write(options.quiet);
  } catch (const InputError&) {
    throw;
  } catch (const std::runtime_error& e) {  // rosbag's, which names no file
    throw InputError(bag, fmt::format("cannot be written: {}", e.what()));
  }
}

}  // namespace uniquadric
