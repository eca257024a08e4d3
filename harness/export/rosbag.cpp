// A ROS 1 bag with the topics that visual, LiDAR and inertial odometry read. Topics and frames:
// docs/export.md.
#include <fmt/format.h>

#include "core/base/error.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/sensor_log.h"
#include "harness/export/writers.h"
#include "harness/rosbag/bag_writer.h"

namespace uniquadric {
namespace {

constexpr const char* kCameraFrame = "camera_optical";

class BagExport {
 public:
  BagExport(const ExportSource& source, const std::filesystem::path& path)
      : source_(source), sequence_(source.sequence), log_(source.sequence), bag_(path) {
    write_static_transforms(log_.first_ns() + log_.shift_ns());
  }

  void write(bool quiet) {
    const auto write_imu = [&](const ImuSample& sample) {
      bag_.imu("/imu", header(sample.stamp_ns, "imu"), sample, *sequence_.imu);
    };
    log_.replay(
        "export rosbag", quiet,
        {write_imu, [&](const SequenceFrame& frame) { write_frame(frame); },
         [&](const SequenceScan& scan, std::int64_t end_ns) { write_scan(scan, end_ns + log_.shift_ns()); }});
    bag_.close();
  }

 private:
  BagHeader header(std::int64_t stamp_ns, const char* frame) const {
    return {stamp_ns + log_.shift_ns(), frame};
  }

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
      bag_.image("/camera/depth/image_raw", camera, ros_depth(sequence_, frame));
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
  SensorLog log_;
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
