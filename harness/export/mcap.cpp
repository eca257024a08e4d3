// An MCAP file of ROS 2 messages, for Foxglove and `ros2 bag play`. Topics and frames: docs/export.md.
#include <fmt/format.h>

#include <algorithm>

#include "core/sequence/object_body.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/sensor_log.h"
#include "harness/export/writers.h"
#include "harness/mcap/mcap_writer.h"
#include "harness/mcap/ros2_messages.h"

namespace uniquadric {
namespace {

constexpr const char *kWorld = "world", *kEstimateWorld = "estimate_world", *kCameraFrame = "camera_optical";
constexpr std::array<float, 4> kTruthColor = {0.1f, 0.7f, 0.2f, 0.5f}, kEstimateColor = {1, 0.5f, 0, 0.5f};

std::string object_frame(const char* whose, int id) {
  return fmt::format("{}object_{}", whose, id);
}

// A truth knows the tight box alone.
Superellipsoid body_of(const ObjectDescription& object) {
  const bool is_round = object.shape == "ball" || object.shape == "ellipsoid";
  return {object.semi_axes_m, is_round ? SuperExponents{} : kBoxExponents, 2};
}

class McapExport {
 public:
  McapExport(const ExportSource& source, const ExportOptions& options, const std::filesystem::path& path)
      : source_(source), sequence_(source.sequence), log_(source.sequence), file_(path) {
    if (!options.estimate.empty()) estimate_ = read_tracks(options.estimate);
  }

  void write(bool quiet) {
    write_static_transforms(log_.first_ns());
    const auto write_imu = [&](const ImuSample& sample) {
      put("/imu", kImuSchema, sample.stamp_ns,
          imu_message(header(sample.stamp_ns, "imu"), sample, *sequence_.imu));
    };
    log_.replay("export mcap", quiet,
                {write_imu, [&](const SequenceFrame& frame) { write_frame(frame); },
                 [&](const SequenceScan& scan, std::int64_t end_ns) { write_scan(scan, end_ns); }});
    file_.close();
  }

 private:
  Ros2Header header(std::int64_t stamp_ns, const char* frame) const {
    return {stamp_ns + log_.shift_ns(), frame};
  }

  void put(const char* topic, const McapSchema& schema, std::int64_t time_ns, const std::string& message) {
    file_.write(topic, schema, time_ns + log_.shift_ns(), message);
  }

  // The estimate's world lies where its camera and the true one agree at first.
  Pose world_from_estimate() const {
    for (const SequenceFrame& frame : sequence_.frames) {
      const auto pose = camera_pose(source_, frame),
                 estimated = pose_at_stamp(estimate_.camera, frame.stamp_ns);
      if (pose && estimated) return *pose * estimated->inverse();
    }
    return {};
  }

  void write_static_transforms(std::int64_t stamp_ns) {
    std::vector<Ros2Transform> transforms;
    const auto add = [&](const char* parent, const char* child, const Pose& pose) {
      transforms.push_back({header(stamp_ns, parent), child, pose});
    };
    if (sequence_.imu) add(kCameraFrame, "imu", sequence_.imu->camera_from_imu);
    if (sequence_.lidar) add(kCameraFrame, "lidar", sequence_.lidar->camera_from_lidar);
    if (!estimate_.camera.empty()) add(kWorld, kEstimateWorld, world_from_estimate());
    if (!transforms.empty()) put("/tf_static", kTransformsSchema, stamp_ns, transforms_message(transforms));
  }

  void write_frame(const SequenceFrame& frame) {
    const std::int64_t stamp_ns = frame.stamp_ns;
    const Ros2Header camera = header(stamp_ns, kCameraFrame);
    const std::string info = camera_info_message(camera, sequence_.camera);
    put("/camera/rgb/image_raw", kImageSchema, stamp_ns, image_message(camera, read_rgb(sequence_, frame)));
    put("/camera/rgb/camera_info", kCameraInfoSchema, stamp_ns, info);
    if (!frame.depth.empty()) {
      put("/camera/depth/image_raw", kImageSchema, stamp_ns,
          image_message(camera, ros_depth(sequence_, frame)));
      put("/camera/depth/camera_info", kCameraInfoSchema, stamp_ns, info);
    }
    std::vector<Ros2Transform> transforms;
    add_truth(frame, transforms);
    add_estimate(frame, transforms);
    if (!transforms.empty()) put("/tf", kTransformsSchema, stamp_ns, transforms_message(transforms));
  }

  void add_truth(const SequenceFrame& frame, std::vector<Ros2Transform>& transforms) {
    const auto pose = camera_pose(source_, frame);
    if (!pose) return;
    const Ros2Header world = header(frame.stamp_ns, kWorld);
    transforms.push_back({world, kCameraFrame, *pose});
    if (!source_.truth) return;
    std::vector<Ros2Solid> solids;
    for (const ObjectAtFrame& object : objects_at(source_, frame)) {
      const int id = object.object->id;
      solids.push_back({id, *pose * object.camera_from_object, body_of(*object.object)});
      transforms.push_back({world, object_frame("", id), solids.back().pose});
    }
    put("/truth/objects", kMarkersSchema, frame.stamp_ns,
        markers_message(world, "truth", solids, kTruthColor));
  }

  void add_estimate(const SequenceFrame& frame, std::vector<Ros2Transform>& transforms) {
    if (estimate_.camera.empty() && estimate_.objects.empty()) return;
    const Ros2Header world = header(frame.stamp_ns, estimate_.camera.empty() ? kWorld : kEstimateWorld);
    if (const auto pose = pose_at_stamp(estimate_.camera, frame.stamp_ns))
      transforms.push_back({world, "estimate_camera", *pose});
    std::vector<Ros2Solid> solids;
    for (const ObjectTrack& track : estimate_.objects) {
      const auto state = std::ranges::lower_bound(track.states, frame.stamp_ns, {}, &ObjectState::stamp_ns);
      if (state == track.states.end() || state->stamp_ns != frame.stamp_ns ||
          state->status == ObjectStatus::lost)
        continue;
      solids.push_back({track.id, state->ellipsoid.world_from_object, uniquadric::body_of(*state)});
      transforms.push_back({world, object_frame("estimate_", track.id), state->ellipsoid.world_from_object});
    }
    put("/estimate/objects", kMarkersSchema, frame.stamp_ns,
        markers_message(world, "estimate", solids, kEstimateColor));
  }

  void write_scan(const SequenceScan& scan, std::int64_t record_ns) {
    const auto points = read_lidar_points(sequence_.folder / scan.file);
    put("/lidar/points", kPointCloudSchema, record_ns,
        point_cloud_message(header(scan.stamp_ns, "lidar"), points));
  }

  const ExportSource& source_;
  const Sequence& sequence_;
  SensorLog log_;
  Tracks estimate_;
  McapWriter file_;
};

}  // namespace

void write_mcap(const ExportSource& source, const ExportOptions& options,
                const std::filesystem::path& folder) {
  McapExport(source, options, folder / (source.sequence.name + ".mcap")).write(options.quiet);
}

}  // namespace uniquadric
