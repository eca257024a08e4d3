// The layout of the EuRoC MAV datasets (Burri et al., IJRR 2016): integer nanoseconds, quaternions w x y z,
// T_BS = body_from_sensor, the body being the IMU.
#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/import/rectify.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Pose camera_from_imu_or_camera(const Sequence& sequence) {
  return sequence.imu ? sequence.imu->camera_from_imu : Pose{};
}

std::string body_from_sensor_yaml(const Pose& body_from_sensor) {
  const Eigen::Matrix4d T = body_from_sensor.matrix();
  std::string text = "T_BS:\n  cols: 4\n  rows: 4\n  data: [";
  for (int i = 0; i < 16; ++i)
    text += fmt::format("{}{}", i == 0 ? "" : i % 4 == 0 ? ",\n         " : ", ", T(i / 4, i % 4));
  return text + "]\n";
}

std::string camera_yaml_text(const Sequence& sequence, bool rectified) {
  const Camera& camera = sequence.camera;
  const auto d = rectified ? std::array<double, 5>{} : camera.distortion;
  return fmt::format(
             "# General sensor definitions.\nsensor_type: camera\ncomment: {}, {}\n\n"
             "# Sensor extrinsics wrt. the body-frame.\n",
             sequence.name, sequence.program) +
         body_from_sensor_yaml(camera_from_imu_or_camera(sequence).inverse()) +
         fmt::format(
             "\n# Camera specific definitions.\nrate_hz: {}\nresolution: [{}, {}]\ncamera_model: pinhole\n"
             "intrinsics: [{}, {}, {}, {}] #fu, fv, cu, cv\ndistortion_model: radial-tangential\n"
             "distortion_coefficients: [{}, {}, {}, {}]\n",
             sequence.rate_hz, camera.width, camera.height, camera.fx, camera.fy, camera.cx, camera.cy, d[0],
             d[1], d[2], d[3]);
}

std::string imu_yaml_text(const Sequence& sequence) {
  const ImuCalibration& imu = *sequence.imu;
  return fmt::format("# General sensor definitions.\nsensor_type: imu\ncomment: {}, {}\n\n", sequence.name,
                     sequence.program) +
         body_from_sensor_yaml(Pose{}) +
         fmt::format(
             "\nrate_hz: {}\n\n# Inertial sensor noise model parameters.\ngyroscope_noise_density: {}\n"
             "gyroscope_random_walk: {}\naccelerometer_noise_density: {}\naccelerometer_random_walk: {}\n",
             imu.rate_hz, imu.gyroscope_noise_radps_rthz, imu.gyroscope_walk_radps2_rthz,
             imu.accelerometer_noise_mps2_rthz, imu.accelerometer_walk_mps3_rthz);
}

void write_imu(const Sequence& sequence, const fs::path& folder) {
  fs::create_directories(folder);
  std::string text =
      "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],"
      "a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]\n";
  for (const ImuSample& sample : read_imu_csv(sequence.folder / "imu.csv")) {
    const Eigen::Vector3d &w = sample.angular_velocity_radps, &a = sample.specific_force_mps2;
    text += fmt::format("{},{},{},{},{},{},{}\n", sample.stamp_ns, w.x(), w.y(), w.z(), a.x(), a.y(), a.z());
  }
  write_text(folder / "data.csv", text);
  write_text(folder / "sensor.yaml", imu_yaml_text(sequence));
}

// By differences between the neighbouring poses: the truth has poses alone.
Eigen::Vector3d velocity_at(const Trajectory& poses, std::size_t i) {
  const StampedPose &before = poses[i == 0 ? 0 : i - 1], &after = poses[std::min(i + 1, poses.size() - 1)];
  if (before.stamp_ns == after.stamp_ns) return Eigen::Vector3d::Zero();
  return (after.pose.translation - before.pose.translation) /
         (static_cast<double>(after.stamp_ns - before.stamp_ns) * 1e-9);
}

// The truth's biases at the last sample up to a stamp; zero where the truth has none.
ImuSample bias_at(const std::vector<ImuSample>& biases, std::int64_t stamp_ns) {
  const auto after = std::upper_bound(biases.begin(), biases.end(), stamp_ns,
                                      [](std::int64_t t, const ImuSample& s) { return t < s.stamp_ns; });
  return after == biases.begin() ? ImuSample{} : *(after - 1);
}

std::string state_text(const ExportSource& source) {
  Trajectory body = camera_poses(source);
  for (StampedPose& pose : body) pose.pose = pose.pose * camera_from_imu_or_camera(source.sequence);
  std::vector<ImuSample> biases;
  if (source.truth && fs::exists(source.truth->folder / "imu_bias.csv"))
    biases = read_imu_csv(source.truth->folder / "imu_bias.csv");
  std::string text =
      "#timestamp, p_RS_R_x [m], p_RS_R_y [m], p_RS_R_z [m], q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], "
      "v_RS_R_x [m s^-1], v_RS_R_y [m s^-1], v_RS_R_z [m s^-1], b_w_RS_S_x [rad s^-1], b_w_RS_S_y [rad "
      "s^-1], "
      "b_w_RS_S_z [rad s^-1], b_a_RS_S_x [m s^-2], b_a_RS_S_y [m s^-2], b_a_RS_S_z [m s^-2]\n";
  for (std::size_t i = 0; i < body.size(); ++i) {
    const Eigen::Vector3d &p = body[i].pose.translation, v = velocity_at(body, i);
    const Eigen::Quaterniond& q = body[i].pose.rotation;
    const ImuSample bias = bias_at(biases, body[i].stamp_ns);
    const Eigen::Vector3d &w = bias.angular_velocity_radps, &a = bias.specific_force_mps2;
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{},{}\n", body[i].stamp_ns, p.x(),
                        p.y(), p.z(), q.w(), q.x(), q.y(), q.z(), v.x(), v.y(), v.z(), w.x(), w.y(), w.z(),
                        a.x(), a.y(), a.z());
  }
  return body.empty() ? "" : text;
}

void write_camera(const Sequence& sequence, const ExportOptions& options, const fs::path& folder) {
  fs::create_directories(folder / "data");
  // The format has four coefficients: a camera with k3 is rectified.
  const bool rectified = sequence.camera.distortion[4] != 0;
  std::string list = "#timestamp [ns],filename\n";
  Progress progress("export euroc", std::ssize(sequence.frames), options.quiet);
  for (const SequenceFrame& frame : sequence.frames) {
    cv::Mat grey;
    cv::cvtColor(read_rgb(sequence, frame), grey, cv::COLOR_BGR2GRAY);
    write_png(folder / fmt::format("data/{}.png", frame.stamp_ns),
              rectified ? rectify(sequence.camera, grey, true) : grey);
    list += fmt::format("{0},{0}.png\n", frame.stamp_ns);
    progress.advance();
  }
  write_text(folder / "data.csv", list);
  write_text(folder / "sensor.yaml", camera_yaml_text(sequence, rectified));
}

}  // namespace

void write_euroc(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  if (!sequence.imu) require_images(sequence, "export euroc (or an IMU)");
  if (!sequence.frames.empty()) write_camera(sequence, options, folder / "mav0/cam0");
  if (sequence.imu) write_imu(sequence, folder / "mav0/imu0");
  if (const std::string text = state_text(source); !text.empty()) {
    const fs::path state = folder / "mav0/state_groundtruth_estimate0";
    fs::create_directories(state);
    write_text(state / "data.csv", text);
    write_text(state / "sensor.yaml", "sensor_type: visual-inertial\ncomment: ground truth of the body\n" +
                                          body_from_sensor_yaml(Pose{}));
  }
}

}  // namespace uniquadric
