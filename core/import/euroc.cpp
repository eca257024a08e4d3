#include "core/import/euroc.h"

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/import/euroc_camera.h"
#include "core/import/fields.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kCameraRateHz = 20;  // of the datasets: one image has no rate
constexpr std::size_t kImuColumns = 7, kStateColumns = 17;

void read_imu(const fs::path& folder, const Pose& body_from_camera, Recording& recording) {
  const ConfigNode sensor = ConfigNode::load(folder / "sensor.yaml");
  ImuCalibration& imu = recording.sequence.imu.emplace();
  imu.camera_from_imu = body_from_camera.inverse() * read_body_from_sensor(sensor);
  imu.gyroscope_noise_radps_rthz = sensor.positive("gyroscope_noise_density");
  imu.gyroscope_walk_radps2_rthz = sensor.positive("gyroscope_random_walk");
  imu.accelerometer_noise_mps2_rthz = sensor.positive("accelerometer_noise_density");
  imu.accelerometer_walk_mps3_rthz = sensor.positive("accelerometer_random_walk");
  const fs::path list = folder / "data.csv";
  recording.imu = read_imu_rows(list, kImuColumns, [&](int line, const Fields& fields) {
    return read_euroc_stamp(list, line, fields[0]);
  });
  imu.rate_hz = nominal_rate_hz(stamps_of(recording.imu), sensor.positive("rate_hz"));
}

Trajectory read_states(const fs::path& path) {
  Trajectory world_from_body;
  for_each_row(path, kStateColumns, [&](int line, const Fields& fields) {
    const std::int64_t stamp_ns = read_euroc_stamp(path, line, fields[0]);
    require_later(path, line, world_from_body, stamp_ns);
    const auto v = read_numbers(path, line, fields, 1);
    const Eigen::Quaterniond rotation(v[3], v[4], v[5], v[6]);
    world_from_body.push_back({stamp_ns, {read_unit(path, line, rotation), {v[0], v[1], v[2]}}});
  });
  return world_from_body;
}

void read_truth(const fs::path& path, const Pose& body_from_camera, Recording& recording) {
  RecordedTruth& truth = recording.truth.emplace();
  truth.camera = camera_poses(path, read_states(path), recording);
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
  EurocCamera camera = read_euroc_camera(mav / "cam0");
  if (options.stereo_depth)
    add_stereo(camera, read_euroc_camera(mav / "cam1"), recording);
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
