#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>

#include "core/geometry/pose.h"
#include "estimator/window/cloud_alignment.h"

namespace uniquadric {

struct SurfaceCloudOptions {
  static constexpr double voxel_share = 0.06;  // ours: of the body's radius: some 800 voxels on its surface
  int min_hits = 3;                            // ours: a voxel that fewer points met is noise
  int max_points = 200;                        // ours: what the long window takes of it; more gain nothing
};

/// Depth points of a body over its keyframes, averaged in voxels of the body's frame. Bounded: voxels beyond
/// three times its reach are refused.
class SurfaceCloud {
 public:
  explicit SurfaceCloud(const SurfaceCloudOptions& options) : options_(options) {}

  /// Forgets everything and takes voxels for a body of this mean radius that reaches so far from its middle.
  void reset(double radius_m, double reach_m);
  /// Points of one view, with their normals and colours where it has them.
  void add(const BodyObservation& body, const Pose& body_from_camera);
  /// At most max_points means of voxels with enough hits, spread evenly (3 x n). Where few have as many
  /// after several views (a LiDAR's points are far apart), the hits of the voxels around one count too.
  Eigen::Matrix3Xd sample() const;
  /// All of them, with normals, and colours where every view had some.
  SurfaceModel model() const;

 private:
  using Cell = std::array<int, 3>;
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero(), normal = Eigen::Vector3d::Zero();
    Eigen::Vector3f color = Eigen::Vector3f::Zero();
    int hits = 0;
  };
  Cell cell_of(const Eigen::Vector3d& point) const;
  bool are_few() const;
  int hits_around(const Cell& cell) const;

  SurfaceCloudOptions options_;
  std::map<Cell, Voxel> voxels_;
  double voxel_m_ = 0.01, reach_m_ = 1;
  int views_ = 0;
  bool is_colored_ = true;
};

}  // namespace uniquadric
