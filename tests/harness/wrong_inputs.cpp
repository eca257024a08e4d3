#include "tests/harness/wrong_inputs.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kMs = 1'000'000;

WrongInput poses(const std::string& name, const std::function<void(Pose&)>& change) {
  return {name, [change](Sequence& s) {
            for (StampedPose& pose : *s.given_camera) change(pose.pose);
          }};
}

WrongInput depths(const std::string& name, const std::function<cv::Mat(const cv::Mat&)>& change) {
  return {name, [change](Sequence& s) {
            for (const SequenceFrame& f : s.frames)
              write_png(s.folder / f.depth, change(read_image(s.folder / f.depth)));
          }};
}

WrongInput masks(const std::string& name, const std::function<cv::Mat(const cv::Mat&)>& change) {
  return {name, [change](Sequence& s) {
            for (const SequenceFrame& f : s.frames)
              write_png(s.folder / f.masks, change(read_image(s.folder / f.masks)));
          }};
}

WrongInput camera(const std::string& name, const std::function<void(Camera&)>& change) {
  return {name, [change](Sequence& s) { change(s.camera); }};
}

WrongInput imu(const std::string& name, const std::function<void(ImuSample&)>& change) {
  return {name, [change](Sequence& s) {
            std::vector<ImuSample> samples = read_imu_csv(s.folder / "imu.csv");
            for (ImuSample& sample : samples) change(sample);
            write_imu_csv(s.folder / "imu.csv", samples);
          }};
}

WrongInput points(const std::string& name, const std::function<void(LidarPoint&)>& change) {
  return {name, [change](Sequence& s) {
            for (const SequenceScan& scan : s.scans) {
              std::vector<LidarPoint> list = read_lidar_points(s.folder / scan.file);
              for (LidarPoint& point : list) change(point);
              write_lidar_points(s.folder / scan.file, list);
            }
          }};
}

cv::Mat flipped(const cv::Mat& image, int code) {
  cv::Mat result;
  cv::flip(image, result, code);
  return result;
}

cv::Mat moved(const cv::Mat& image, int dx, int dy) {
  cv::Mat result = cv::Mat::zeros(image.size(), image.type());
  const cv::Rect all(0, 0, image.cols, image.rows);
  const cv::Rect to = (all + cv::Point(dx, dy)) & all;
  image(to - cv::Point(dx, dy)).copyTo(result(to));
  return result;
}

// Files of a frame taken from another, k before; the first ones stay.
void delay(Sequence& s, fs::path SequenceFrame::*file, int k) {
  std::vector<fs::path> files;
  for (const SequenceFrame& frame : s.frames) files.push_back(frame.*file);
  const int last = static_cast<int>(files.size()) - 1;
  for (int i = 0; i <= last; ++i) s.frames[i].*file = files[std::clamp(i - k, 0, last)];
}

template <typename Stamped>
void scale_stamps(std::vector<Stamped>& list, double factor) {
  for (Stamped& item : list) item.stamp_ns = std::llround(static_cast<double>(item.stamp_ns) * factor);
}

void scale_arrivals(Sequence& s) {
  for (SequenceFrame& frame : s.frames)
    frame.masks_arrival_ns = std::max(frame.masks_arrival_ns, frame.stamp_ns);
}

void mirror_y(Pose& pose) {
  const Eigen::Matrix3d S = Eigen::Vector3d(1, -1, 1).asDiagonal();
  pose.rotation = Eigen::Quaterniond(Eigen::Matrix3d(S * pose.rotation.toRotationMatrix() * S));
  pose.translation = S * pose.translation;
}

Eigen::Quaterniond turn(const Eigen::Matrix3d& columns) {
  return Eigen::Quaterniond(columns);
}

// Each image's depth as the distance from the camera.
void ray_lengths(Sequence& s) {
  for (const SequenceFrame& f : s.frames) {
    cv::Mat units = read_image(s.folder / f.depth);
    for (int v = 0; v < units.rows; ++v)
      for (int u = 0; u < units.cols; ++u) {
        const auto ray = s.camera.unproject({u, v});
        auto& value = units.at<std::uint16_t>(v, u);
        if (ray) value = static_cast<std::uint16_t>(std::min(65000.0, value * ray->norm()));
      }
    write_png(s.folder / f.depth, units);
  }
}

std::vector<WrongInput> wrong_poses() {
  const Eigen::Matrix3d forward{{0, -1, 0}, {0, 0, -1}, {1, 0, 0}};  // optical from x forward
  const Eigen::Matrix3d graphics{{1, 0, 0}, {0, -1, 0}, {0, 0, -1}};
  return {
      poses("poses inverted", [](Pose& p) { p = p.inverse(); }),
      poses("quaternions w x y z",
            [](Pose& p) {
              const Eigen::Quaterniond q = p.rotation;
              p.rotation.coeffs() = Eigen::Vector4d(q.w(), q.x(), q.y(), q.z());
            }),
      poses("poses left-handed", mirror_y),
      poses("poses in mm", [](Pose& p) { p.translation *= 1000; }),
      poses("poses in cm", [](Pose& p) { p.translation *= 100; }),
      poses("poses x forward", [forward](Pose& p) { p.rotation = p.rotation * turn(forward); }),
      poses("poses of OpenGL's camera", [graphics](Pose& p) { p.rotation = p.rotation * turn(graphics); }),
      poses("rotations inverted", [](Pose& p) { p.rotation = p.rotation.conjugate(); }),
      poses("poses all the same", [](Pose& p) { p = Pose(); }),
      poses("z of positions negated", [](Pose& p) { p.translation.z() *= -1; }),
      {"poses late by 3 frames",
       [](Sequence& s) {
         for (StampedPose& pose : *s.given_camera) pose.stamp_ns += 100 * kMs;
       }},
      {"poses on another clock",
       [](Sequence& s) {
         for (StampedPose& pose : *s.given_camera) pose.stamp_ns += 1'700'000'000'000 * kMs;
       }},
  };
}

std::vector<WrongInput> wrong_depth() {
  return {
      depths("depth mirrored", [](const cv::Mat& d) { return flipped(d, 1); }),
      depths("depth upside down", [](const cv::Mat& d) { return flipped(d, 0); }),
      depths("depth turned by 180 degrees", [](const cv::Mat& d) { return flipped(d, -1); }),
      {"depth of one image for all",
       [](Sequence& s) {
         for (SequenceFrame& frame : s.frames) frame.depth = s.frames[0].depth;
       }},
      {"depth late by 3 frames", [](Sequence& s) { delay(s, &SequenceFrame::depth, 3); }},
      {"depth early by 2 frames", [](Sequence& s) { delay(s, &SequenceFrame::depth, -2); }},
      depths("depth not registered to colour", [](const cv::Mat& d) { return moved(d, 8, 2); }),
      {"depth scaled by 10 %", [](Sequence& s) { s.depth_units_per_m *= 1.1; }},
      {"depth in other units", [](Sequence& s) { s.depth_units_per_m *= 5; }},
      {"depth is length of rays", ray_lengths},
      depths("depth is inverse depth",
             [](const cv::Mat& d) {
               cv::Mat inverse = d.clone();
               for (auto& value : cv::Mat_<std::uint16_t>(inverse))
                 if (value > 0) value = static_cast<std::uint16_t>(std::min(60000, 4'000'000 / value));
               return inverse;
             }),
  };
}

std::vector<WrongInput> wrong_calibration() {
  return {
      camera("cx and cy swapped", [](Camera& c) { std::swap(c.cx, c.cy); }),
      camera("fx unlike fy", [](Camera& c) { c.fy *= 1.25; }),
      camera("focal length off by 20 %", [](Camera& c) { c.fx *= 1.2, c.fy *= 1.2; }),
      camera("focal length of half the image", [](Camera& c) { c.fx *= 2, c.fy *= 2, c.cx *= 2, c.cy *= 2; }),
      camera("principal point at the corner", [](Camera& c) { c.cx = c.cy = 0; }),
      camera("distortion of another lens",
             [](Camera& c) {
               c.distortion = {-0.35, 0.12, 0, 0, 0};
             }),
  };
}

std::vector<WrongInput> wrong_stamps() {
  return {
      {"stamps in ms",
       [](Sequence& s) {
         scale_stamps(s.frames, 1000);
         scale_arrivals(s);
         if (s.given_camera) scale_stamps(*s.given_camera, 1000);
         s.rate_hz /= 1000;
       }},
      {"stamps divided by 1000",
       [](Sequence& s) {
         scale_stamps(s.frames, 0.001);
         scale_arrivals(s);
         if (s.given_camera) scale_stamps(*s.given_camera, 0.001);
         s.rate_hz *= 1000;
       }},
  };
}

std::vector<WrongInput> wrong_masks() {
  return {
      masks("masks mirrored", [](const cv::Mat& m) { return flipped(m, 1); }),
      {"masks late by 4 frames", [](Sequence& s) { delay(s, &SequenceFrame::masks, 4); }},
      {"masks of one image for all",
       [](Sequence& s) {
         for (SequenceFrame& frame : s.frames) frame.masks = s.frames[0].masks;
       }},
  };
}

std::vector<WrongInput> wrong_imu() {
  return {
      imu("gyroscope in deg/s", [](ImuSample& i) { i.angular_velocity_radps *= 180 / std::numbers::pi; }),
      imu("IMU's x and y swapped",
          [](ImuSample& i) {
            std::swap(i.angular_velocity_radps.x(), i.angular_velocity_radps.y());
            std::swap(i.specific_force_mps2.x(), i.specific_force_mps2.y());
          }),
      imu("accelerometer's y and z swapped",
          [](ImuSample& i) { std::swap(i.specific_force_mps2.y(), i.specific_force_mps2.z()); }),
      imu("gyroscope negated", [](ImuSample& i) { i.angular_velocity_radps *= -1; }),
      imu("accelerometer in g", [](ImuSample& i) { i.specific_force_mps2 /= 9.81; }),
      imu("accelerometer negated", [](ImuSample& i) { i.specific_force_mps2 *= -1; }),
      imu("gyroscope and accelerometer swapped",
          [](ImuSample& i) { std::swap(i.angular_velocity_radps, i.specific_force_mps2); }),
      imu("IMU late by 0.15 s", [](ImuSample& i) { i.stamp_ns += 150 * kMs; }),
      imu("IMU on another clock", [](ImuSample& i) { i.stamp_ns += 1'000'000 * kMs; }),
      {"IMU's place inverted",
       [](Sequence& s) { s.imu->camera_from_imu = s.imu->camera_from_imu.inverse(); }},
  };
}

std::vector<WrongInput> wrong_scans() {
  return {
      points("points in mm", [](LidarPoint& p) { p.x *= 1000, p.y *= 1000, p.z *= 1000; }),
      points("points without times", [](LidarPoint& p) { p.offset_ns = 0; }),
      points("points' times in us", [](LidarPoint& p) { p.offset_ns /= 1000; }),
      points("points mirrored", [](LidarPoint& p) { p.y = -p.y; }),
      points("points y forward", [](LidarPoint& p) { std::swap(p.x, p.y), p.x = -p.x; }),
      {"LiDAR's place inverted",
       [](Sequence& s) { s.lidar->camera_from_lidar = s.lidar->camera_from_lidar.inverse(); }},
      {"scans repeated",
       [](Sequence& s) {
         for (std::size_t i = 1; i < s.scans.size(); i += 2)
           fs::copy_file(s.folder / s.scans[i - 1].file, s.folder / s.scans[i].file,
                         fs::copy_options::overwrite_existing);
       }},
      {"scans late by 0.2 s",
       [](Sequence& s) {
         for (SequenceScan& scan : s.scans) scan.stamp_ns += 200 * kMs;
         s.scans.resize(s.scans.size() - 3);
       }},
  };
}

template <typename... Lists>
std::vector<WrongInput> joined(Lists... lists) {
  std::vector<WrongInput> all;
  (all.insert(all.end(), lists.begin(), lists.end()), ...);
  return all;
}

}  // namespace

std::vector<WrongInput> wrong_camera_inputs() {
  return joined(wrong_poses(), wrong_depth(), wrong_calibration(), wrong_stamps(), wrong_masks(),
                wrong_imu());
}

std::vector<WrongInput> wrong_scan_inputs() {
  return joined(wrong_scans());
}

void write_wrong(const WrongInput& input, const fs::path& from, const fs::path& to) {
  fs::copy(from, to, fs::copy_options::recursive);
  fs::remove(to / "hashes.txt");
  Sequence sequence = open_sequence(to);
  sequence.scene_hash.clear();  // as a recording
  input.make(sequence);
  write_sequence_index(to, sequence);
}

}  // namespace uniquadric
