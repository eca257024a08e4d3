#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

namespace uniquadric {

/// A 4x4 world_from_something at a time.
struct StampedMatrix {
  std::int64_t stamp_ns = 0;
  Eigen::Matrix4d matrix = Eigen::Matrix4d::Identity();
};

/// What a recording saw, to be written in other tools' layouts as their papers and readers describe them:
/// with 4x4 matrices and no word of the program's own importers and exporters.
struct RecordedWorld {
  int width = 8, height = 6;
  double fx = 10, fy = 11, cx = 3.5, cy = 2.5;        // px
  std::array<double, 4> distortion{};                 // k1 k2 p1 p2
  std::vector<std::int64_t> stamps_ns;                // of the frames
  std::vector<cv::Mat> colors, depths_m, ids;         // a frame: 8UC3, 32FC1 (0: none), 16UC1
  std::vector<StampedMatrix> camera;                  // world_from_camera, at any times
  std::map<int, std::vector<StampedMatrix>> objects;  // world_from_object by id
  struct Imu {
    std::int64_t stamp_ns = 0;
    Eigen::Vector3d gyro, accel;
  };
  std::vector<Imu> imu;
  Eigen::Matrix4d camera_from_imu = Eigen::Matrix4d::Identity();
  std::vector<cv::Mat> right_colors;  // of a second camera like the first, may be none
  Eigen::Matrix4d right_from_left = Eigen::Matrix4d::Identity();
};

/// A rotation about an axis by an angle [rad], and a translation [m].
Eigen::Matrix4d rigid(const Eigen::Vector3d& axis, double angle, const Eigen::Vector3d& translation);

/// How vicon.csv states quaternion and translation beside its 4x4 object_from_world.
enum class ViconDirection { world_from_object, object_from_world };

/// Raw layout of the Oxford Multimotion Dataset: rgbd/, vicon.csv (the bodies are box1, ...; its clock is
/// `vicon_late_ns` late), imu.csv, kalibr and vicon calibration. Indices begin at 100.
void write_omd_raw(const RecordedWorld& world, const std::filesystem::path& folder,
                   ViconDirection direction = ViconDirection::world_from_object,
                   std::int64_t vicon_late_ns = 0);

/// The processed layout, with disparities (bf 387.5744, 1000 a pixel) or, where `metric_units` is not 0,
/// depths. Poses are those at the frames' stamps.
void write_omd_processed(const RecordedWorld& world, const std::filesystem::path& folder,
                         double metric_units = 0);

/// EuRoC's layout, the IMU being the body: cam0, imu0, where there is a second camera cam1,
/// state_groundtruth_estimate0.
void write_euroc_layout(const RecordedWorld& world, const std::filesystem::path& folder);

}  // namespace uniquadric
