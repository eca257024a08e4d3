#include "core/import/euroc.h"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <memory>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/fields.h"
#include "core/import/images.h"
#include "core/import/pinhole.h"
#include "core/import/stereo.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kCameraRateHz = 20;  // of the datasets: one image has no rate
constexpr double kDepthUnitsPerM = 1000;
constexpr std::size_t kImuColumns = 7, kStateColumns = 17;

std::int64_t read_stamp(const fs::path& path, int line, std::string_view field) {
  const auto stamp = parse_integer(field);
  if (!stamp || *stamp < 0)
    throw InputError(path, line, fmt::format("'{}' is not a stamp in nanoseconds", field));
  return *stamp;
}

Pose read_body_from_sensor(const ConfigNode& sensor) {
  return read_pose_matrix(sensor.at("T_BS").at("data"));
}

struct EurocCamera {
  fs::path folder;
  Camera camera;
  Pose body_from_camera;
  std::map<std::int64_t, fs::path> images;  // by stamp
};

EurocCamera read_camera(const fs::path& folder) {
  EurocCamera camera{folder, {}, {}, {}};
  const ConfigNode sensor = ConfigNode::load(folder / "sensor.yaml");
  camera.camera = read_pinhole_camera(sensor, "distortion_coefficients");
  camera.body_from_camera = read_body_from_sensor(sensor);
  const fs::path list = folder / "data.csv";
  for_each_row(list, 2, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_stamp(list, line, fields[0]);
    require_later(list, line,
                  camera.images.empty() ? std::nullopt : std::optional(camera.images.rbegin()->first),
                  stamp_ns);
    if (!is_plain_name(fields[1]) || fields[1].starts_with('.'))
      throw InputError(list, line, fmt::format("'{}' is no name of an image", fields[1]));
    camera.images[stamp_ns] = folder / "data" / fields[1];
    if (!fs::is_regular_file(camera.images[stamp_ns]))
      throw InputError(list, line, fmt::format("file data/{} is missing", fields[1]));
  });
  if (camera.images.empty()) throw InputError(list, "names no image");
  return camera;
}

cv::Mat color_of(const fs::path& path, const Camera& camera) {
  const auto made = make_color(path);
  const cv::Mat color = made ? *made : read_image(path);
  require_image(path, color, camera, ImageKind::color);
  return color;
}

void add_images(const EurocCamera& camera, Recording& recording) {
  for (const auto& [stamp_ns, source] : camera.images) {
    const SequenceFrame& frame =
        add_frame(recording.sequence, stamp_ns, fmt::format("rgb/{}.png", format_stamp(stamp_ns)));
    recording.images.push_back({source, frame.rgb, ImageKind::color, make_color});
  }
}

StereoRig make_rig(const EurocCamera& left, const EurocCamera& right) {
  const Pose right_from_left = right.body_from_camera.inverse() * left.body_from_camera;
  const Eigen::Vector3d& t = right_from_left.translation;
  if (t.x() >= 0 || std::abs(t.y()) > -t.x())
    throw InputError(right.folder / "sensor.yaml", "T_BS: cam1 does not lie to the right of cam0");
  if (left.camera.width != right.camera.width || left.camera.height != right.camera.height)
    throw InputError(right.folder / "sensor.yaml", "resolution: is not that of cam0");
  return {left.camera, right.camera, right_from_left};
}

// Rectified images and their depth; `left` becomes the camera that sees them.
void add_stereo(EurocCamera& left, const EurocCamera& right, Recording& recording) {
  const auto rig = std::make_shared<const StereoRig>(make_rig(left, right));
  recording.sequence.depth_units_per_m = kDepthUnitsPerM;
  for (const auto& [stamp_ns, source] : left.images) {
    const std::string name = format_stamp(stamp_ns) + ".png";
    SequenceFrame& frame = add_frame(recording.sequence, stamp_ns, "rgb/" + name);
    recording.images.push_back(
        {source, frame.rgb, ImageKind::color, [rig, camera = left.camera](const fs::path& path) {
           return rig->rectify_left(color_of(path, camera));
         }});
    const auto other = right.images.find(stamp_ns);
    if (other == right.images.end()) continue;
    frame.depth = "depth/" + name;
    recording.images.push_back(
        {source, frame.depth, ImageKind::depth,
         [rig, a = left.camera, b = right.camera, file = other->second](const fs::path& path) {
           return rig->depth(color_of(path, a), color_of(file, b), kDepthUnitsPerM);
         }});
  }
  left.camera = rig->camera();
  left.body_from_camera = left.body_from_camera * rig->rectified_from_left().inverse();
}

void read_imu(const fs::path& folder, const Pose& body_from_camera, Recording& recording) {
  const ConfigNode sensor = ConfigNode::load(folder / "sensor.yaml");
  ImuCalibration& imu = recording.sequence.imu.emplace();
  imu.camera_from_imu = body_from_camera.inverse() * read_body_from_sensor(sensor);
  imu.gyroscope_noise_radps_rthz = sensor.positive("gyroscope_noise_density");
  imu.gyroscope_walk_radps2_rthz = sensor.positive("gyroscope_random_walk");
  imu.accelerometer_noise_mps2_rthz = sensor.positive("accelerometer_noise_density");
  imu.accelerometer_walk_mps3_rthz = sensor.positive("accelerometer_random_walk");
  const fs::path list = folder / "data.csv";
  std::vector<std::int64_t> stamps_ns;
  for_each_row(list, kImuColumns, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_stamp(list, line, fields[0]);
    require_later(list, line, stamps_ns.empty() ? std::nullopt : std::optional(stamps_ns.back()), stamp_ns);
    stamps_ns.push_back(stamp_ns);
    const auto v = read_numbers(list, line, fields, 1);
    recording.imu.push_back({stamp_ns, {v[0], v[1], v[2]}, {v[3], v[4], v[5]}});
  });
  if (stamps_ns.empty()) throw InputError(list, "has no sample");
  imu.rate_hz = nominal_rate_hz(stamps_ns, sensor.positive("rate_hz"));
}

Trajectory read_states(const fs::path& path) {
  Trajectory world_from_body;
  for_each_row(path, kStateColumns, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_stamp(path, line, fields[0]);
    require_later(path, line,
                  world_from_body.empty() ? std::nullopt : std::optional(world_from_body.back().stamp_ns),
                  stamp_ns);
    const auto v = read_numbers(path, line, fields, 1);
    const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
    world_from_body.push_back({stamp_ns, {read_unit(path, line, rotation), {v[0], v[1], v[2]}}});
  });
  return world_from_body;
}

void read_truth(const fs::path& path, const Pose& body_from_camera, Recording& recording) {
  RecordedTruth& truth = recording.truth.emplace();
  truth.camera = trajectory_at(read_states(path), stamps_of(recording.sequence.frames));
  for (StampedPose& pose : truth.camera) {
    pose.pose = pose.pose * body_from_camera;
    pose.pose.rotation.normalize();
  }
  recording.sequence.given_camera = truth.camera;
}

Recording read_recording(const fs::path& folder, const ImportEurocOptions& options) {
  const fs::path mav = fs::is_directory(folder / "mav0") ? folder / "mav0" : folder;
  if (!fs::is_directory(mav / "cam0")) throw InputError(folder, "holds no recording: there is no mav0/cam0/");
  if (options.stereo_depth && !fs::is_directory(mav / "cam1"))
    throw InputError(folder, "there is no mav0/cam1/, which depth needs; --depth none takes cam0 alone");
  Recording recording;
  recording.sequence = begin_sequence(recording_name(folder));
  EurocCamera camera = read_camera(mav / "cam0");
  if (options.stereo_depth)
    add_stereo(camera, read_camera(mav / "cam1"), recording);
  else
    add_images(camera, recording);
  recording.sequence.camera = camera.camera;
  recording.sequence.rate_hz = nominal_rate_hz(stamps_of(recording.sequence.frames), kCameraRateHz);
  if (fs::is_directory(mav / "imu0")) read_imu(mav / "imu0", camera.body_from_camera, recording);
  if (const fs::path states = mav / "state_groundtruth_estimate0/data.csv"; fs::exists(states))
    read_truth(states, camera.body_from_camera, recording);
  return recording;
}

}  // namespace

void import_euroc(const fs::path& recording, const ImportEurocOptions& options, const fs::path& out) {
  if (!fs::is_directory(recording)) throw InputError(recording, "is not a folder");
  write_recording(read_recording(recording, options), options, out);
}

}  // namespace uniquadric
