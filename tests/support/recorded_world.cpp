#include "tests/support/recorded_world.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <fstream>
#include <opencv2/imgcodecs.hpp>

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Eigen::Matrix4d;

// Of the rig that write_omd_raw() makes up.
const Matrix4d kApparatusFromLeft = rigid({1, -2, 1}, 1.9, {0.11, -0.02, 0.07});
const Matrix4d kRightFromLeft = rigid({0, 1, 0}, 0.01, {-0.16, 0.001, 0.002});
const Matrix4d kRgbdFromRight = rigid({1, 0, 1}, -0.03, {0.08, 0.05, -0.01});

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << text;
}

void write(const fs::path& path, const cv::Mat& image) {
  fs::create_directories(path.parent_path());
  cv::imwrite(path.string(), image);
}

// Numbers of a matrix row by row, with 15 digits.
std::string numbers(const Eigen::MatrixXd& m, const char* separator) {
  std::string text;
  for (int i = 0; i < m.rows(); ++i)
    for (int j = 0; j < m.cols(); ++j)
      text += fmt::format("{}{:.15g}", text.empty() ? "" : separator, m(i, j));
  return text;
}

// Rows of a YAML list, as kalibr writes them.
std::string rows(const Matrix4d& m) {
  std::string text;
  for (int i = 0; i < 4; ++i) text += "  - [" + numbers(m.row(i), ", ") + "]\n";
  return text;
}

std::string seconds_and_ns(std::int64_t stamp_ns) {
  return fmt::format("{},{}", stamp_ns / 1'000'000'000, stamp_ns % 1'000'000'000);
}

Eigen::Quaterniond rotation_of(const Matrix4d& m) {
  return Eigen::Quaterniond(Eigen::Matrix3d(m.topLeftCorner<3, 3>()));
}

std::string vicon_row(std::int64_t stamp_ns, const std::string& name, const Matrix4d& world_from_object,
                      ViconDirection direction) {
  const Matrix4d object_from_world = world_from_object.inverse();
  const Matrix4d& stated =
      direction == ViconDirection::world_from_object ? world_from_object : object_from_world;
  return fmt::format("{},{},{},{},{}\n", seconds_and_ns(stamp_ns), name,
                     numbers(rotation_of(stated).coeffs().transpose(), ","),
                     numbers(stated.topRightCorner<3, 1>().transpose(), ","),
                     numbers(object_from_world, ","));
}

cv::Mat in_units(const cv::Mat& depth_m, double units) {
  cv::Mat image;
  depth_m.convertTo(image, CV_16U, units);
  return image;
}

const Matrix4d* at(const std::vector<StampedMatrix>& poses, std::int64_t stamp_ns) {
  for (const StampedMatrix& pose : poses)
    if (pose.stamp_ns == stamp_ns) return &pose.matrix;
  return nullptr;
}

void write_rig(const RecordedWorld& w, const fs::path& folder) {
  const auto camera = [](const char* name, const std::string& rest) {
    return fmt::format("{}:\n  cam_overlaps: [1]\n  camera_model: pinhole\n{}", name, rest);
  };
  const std::string stereo =
      "  distortion_coeffs: [0.1, 0, 0, 0]\n  distortion_model: radtan\n"
      "  intrinsics: [1, 1, 1, 1]\n  resolution: [2, 2]\n";
  write(folder / "kalibr_2019_06_14.yaml",
        camera("cam0", stereo) + camera("cam1", "  T_cn_cnm1:\n" + rows(kRightFromLeft) + stereo) +
            camera("cam2",
                   "  T_cam_imu:\n" + rows(w.camera_from_imu) + "  T_cn_cnm1:\n" + rows(kRgbdFromRight) +
                       fmt::format("  distortion_coeffs: [{}, {}, {}, {}]\n  distortion_model: radtan\n"
                                   "  intrinsics: [{}, {}, {}, {}]\n  resolution: [{}, {}]\n"
                                   "  rostopic: /camera/color\n",
                                   w.distortion[0], w.distortion[1], w.distortion[2], w.distortion[3], w.fx,
                                   w.fy, w.cx, w.cy, w.width, w.height)));
  write(folder / "vicon_2019_06_14.yaml", "T_apparatus_left:\n" + rows(kApparatusFromLeft));
}

std::string t_bs(const Matrix4d& body_from_sensor) {
  return "T_BS:\n  cols: 4\n  rows: 4\n  data: [" + numbers(body_from_sensor, ", ") + "]\n";
}

void write_euroc_camera(const RecordedWorld& w, const fs::path& folder, const std::vector<cv::Mat>& colors,
                        const Matrix4d& body_from_camera) {
  std::string list = "#timestamp [ns],filename\n";
  for (std::size_t i = 0; i < w.stamps_ns.size(); ++i) {
    list += fmt::format("{0},{0}.png\n", w.stamps_ns[i]);
    cv::Mat grey;
    cv::extractChannel(colors[i], grey, 1);
    write(folder / fmt::format("data/{}.png", w.stamps_ns[i]), grey);
  }
  write(folder / "data.csv", list);
  write(folder / "sensor.yaml",
        "# General sensor definitions.\nsensor_type: camera\ncomment: VI-Sensor\n" + t_bs(body_from_camera) +
            fmt::format("rate_hz: 20\nresolution: [{}, {}]\ncamera_model: pinhole\n"
                        "intrinsics: [{}, {}, {}, {}]\ndistortion_model: radial-tangential\n"
                        "distortion_coefficients: [{}, {}, {}, {}]\n",
                        w.width, w.height, w.fx, w.fy, w.cx, w.cy, w.distortion[0], w.distortion[1],
                        w.distortion[2], w.distortion[3]));
}

}  // namespace

Matrix4d rigid(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& translation) {
  Matrix4d T = Matrix4d::Identity();
  T.topLeftCorner<3, 3>() = Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
  T.topRightCorner<3, 1>() = translation;
  return T;
}

void write_omd_raw(const RecordedWorld& w, const fs::path& folder, ViconDirection direction,
                   std::int64_t vicon_late_ns) {
  write_rig(w, folder);
  std::string list = "frame_num,time_sec,time_nsec\n";
  for (std::size_t i = 0; i < w.stamps_ns.size(); ++i) {
    list += fmt::format("{},{}\n", 100 + i, seconds_and_ns(w.stamps_ns[i]));
    write(folder / fmt::format("rgbd/{:06}_color.png", 100 + i), w.colors[i]);
    write(folder / fmt::format("rgbd/{:06}_aligned_depth.png", 100 + i), in_units(w.depths_m[i], 1000));
  }
  write(folder / "rgbd/rgbd.csv", list);
  const Matrix4d apparatus_from_rgbd =
      kApparatusFromLeft * kRightFromLeft.inverse() * kRgbdFromRight.inverse();
  std::string vicon = "time_sec,time_nsec,object,qx,qy,qz,qw,x,y,z,m00,m01,m02,m03,...\n";
  for (const StampedMatrix& pose : w.camera) {
    vicon += vicon_row(pose.stamp_ns + vicon_late_ns, "sensor_payload",
                       pose.matrix * apparatus_from_rgbd.inverse(), direction);
    for (const auto& [id, poses] : w.objects)
      if (const Matrix4d* world_from_object = at(poses, pose.stamp_ns))
        vicon +=
            vicon_row(pose.stamp_ns + vicon_late_ns, fmt::format("box{}", id), *world_from_object, direction);
  }
  write(folder / "vicon.csv", vicon);
  std::string imu = "time_sec,time_nsec,qx,qy,qz,qw,wx,wy,wz,ax,ay,az\n";
  for (const auto& sample : w.imu)
    imu += fmt::format("{},0,0,0,1,{},{}\n", seconds_and_ns(sample.stamp_ns),
                       numbers(sample.gyro.transpose(), ","), numbers(sample.accel.transpose(), ","));
  write(folder / "imu.csv", imu);
}

void write_omd_processed(const RecordedWorld& w, const fs::path& folder, double metric_units) {
  constexpr double kBf = 387.5744, kDisparityUnits = 1000;
  write(folder / "omd.yaml",
        fmt::format(
            "%YAML:1.0\n\n# Camera Parameters\nCamera.fx: {} # px\nCamera.fy: {}\nCamera.cx: {}\n"
            "Camera.cy: {}\nCamera.k1: {}\nCamera.k2: {}\nCamera.p1: {}\nCamera.p2: {}\nCamera.k3: 0.0\n"
            "Camera.width: {}\nCamera.height: {}\nCamera.bf: {}\nDepthMapFactor: {}\nThDepthBG: 40.0\n",
            w.fx, w.fy, w.cx, w.cy, w.distortion[0], w.distortion[1], w.distortion[2], w.distortion[3],
            w.width, w.height, kBf, metric_units > 0 ? metric_units : kDisparityUnits));
  std::string times, camera, objects;
  for (std::size_t i = 0; i < w.stamps_ns.size(); ++i) {
    times += fmt::format("{}.{:09}\n", w.stamps_ns[i] / 1'000'000'000, w.stamps_ns[i] % 1'000'000'000);
    write(folder / fmt::format("image_0/{:06}.png", i), w.colors[i]);
    cv::Mat depth = in_units(w.depths_m[i], metric_units);
    if (metric_units == 0)
      for (int v = 0; v < depth.rows; ++v)
        for (int u = 0; u < depth.cols; ++u)
          if (const float z = w.depths_m[i].at<float>(v, u); z > 0)
            depth.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(kBf / z * kDisparityUnits + 0.5);
    write(folder / fmt::format("depth/{:06}.png", i), depth);
    std::string ids;
    for (int v = 0; v < w.height; ++v)
      for (int u = 0; u < w.width; ++u)
        ids += fmt::format("{}{}", w.ids[i].at<std::uint16_t>(v, u), u + 1 < w.width ? ' ' : '\n');
    write(folder / fmt::format("semantic/{:06}.txt", i), ids);
    if (const Matrix4d* pose = at(w.camera, w.stamps_ns[i]))
      camera += fmt::format("{} {}\n", i, numbers(*pose, " "));
    for (const auto& [id, poses] : w.objects)
      if (const Matrix4d* pose = at(poses, w.stamps_ns[i])) {
        const Eigen::AngleAxisd turn(rotation_of(*pose));
        objects += fmt::format("{} {} {} {}\n", i, id, numbers(pose->topRightCorner<3, 1>().transpose(), " "),
                               numbers((turn.angle() * turn.axis()).transpose(), " "));
      }
  }
  write(folder / "times.txt", times);
  write(folder / "pose_gt.txt", camera);
  write(folder / "object_pose.txt", objects);
}

void write_euroc_layout(const RecordedWorld& w, const fs::path& folder) {
  const fs::path mav = folder / "mav0";
  const Matrix4d body_from_left = w.camera_from_imu.inverse();
  write_euroc_camera(w, mav / "cam0", w.colors, body_from_left);
  if (!w.right_colors.empty())
    write_euroc_camera(w, mav / "cam1", w.right_colors, body_from_left * w.right_from_left.inverse());
  write(mav / "imu0/sensor.yaml",
        "sensor_type: imu\n" + t_bs(Matrix4d::Identity()) +
            "rate_hz: 200\ngyroscope_noise_density: 1.5e-04\ngyroscope_random_walk: 2.5e-05\n"
            "accelerometer_noise_density: 3.5e-3\naccelerometer_random_walk: 4.5e-3\n");
  std::string imu = "#timestamp [ns],w_RS_S_x,w_RS_S_y,w_RS_S_z,a_RS_S_x,a_RS_S_y,a_RS_S_z\n";
  for (const auto& sample : w.imu)
    imu += fmt::format("{},{},{}\n", sample.stamp_ns, numbers(sample.gyro.transpose(), ","),
                       numbers(sample.accel.transpose(), ","));
  write(mav / "imu0/data.csv", imu);
  std::string states =
      "#timestamp, p_RS_R_x [m], ..., q_RS_w [], q_RS_x [], q_RS_y [], q_RS_z [], v, b_w, b_a\n";
  for (const StampedMatrix& pose : w.camera) {
    const Matrix4d world_from_body = pose.matrix * w.camera_from_imu;
    const Eigen::Quaterniond q = rotation_of(world_from_body);
    states += fmt::format("{},{},{:.15g},{:.15g},{:.15g},{:.15g},0,0,0,0,0,0,0,0,0\n", pose.stamp_ns,
                          numbers(world_from_body.topRightCorner<3, 1>().transpose(), ","), q.w(), q.x(),
                          q.y(), q.z());
  }
  write(mav / "state_groundtruth_estimate0/data.csv", states);
}

}  // namespace uniquadric
