#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

struct CloudOptions {
  double voxel_m = 0.005;   // ours: half the noise of a depth camera at 2 m
  int max_voxels = 40'000;  // ours: 5 MB; beyond it the voxels' side doubles
  double noise_per_range =
      0.005;                     // ours: a depth camera's, along the line of sight; a LiDAR's is in the floor
  double noise_floor_m = 0.003;  // ours: of the poses, in every direction
};

/// Points of a body from many frames, in the body's frame. Memory is bounded: each voxel keeps the number of
/// its points, their mean and their mean noise.
class AccumulatedCloud {
 public:
  struct Voxel {
    double count = 0;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    Eigen::Matrix3d noise_sum = Eigen::Matrix3d::Zero();  ///< of the points' covariances [m^2]
  };

  explicit AccumulatedCloud(const CloudOptions& options = {})
      : options_(options), voxel_m_(options.voxel_m) {}

  /// Adds the points (3 x n, camera frame, metres) of one frame.
  void add(const Eigen::Matrix3Xd& points, const Pose& body_from_camera);

  /// Moves everything added so far: after it the cloud is in a frame `to` with to_from_body.
  void transform(const Pose& to_from_body);

  Eigen::Matrix3Xd points() const;  ///< means of the voxels
  Eigen::VectorXd weights() const;  ///< and how many points each stands for
  /// Variance along a direction (unit), averaged over the third of the points furthest along it [m^2].
  double noise_variance(const Eigen::Vector3d& direction) const;
  const std::vector<Eigen::Vector3d>& cameras() const { return cameras_; }  ///< their centres, body frame
  double voxel_m() const { return voxel_m_; }

 private:
  void insert(const Voxel& voxel);
  void coarsen();

  CloudOptions options_;
  double voxel_m_;
  std::unordered_map<std::uint64_t, std::size_t> index_;  // of the voxel at a place
  std::vector<Voxel> voxels_;                             // in the order of their first points
  std::vector<Eigen::Vector3d> cameras_;
};

}  // namespace uniquadric
