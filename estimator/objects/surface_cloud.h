#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <map>

namespace uniquadric {

struct SurfaceCloudOptions {
  double voxel_share = 0.06;  // ours: of the body's radius: some 800 voxels on its surface
  int min_hits = 3;           // ours: a voxel that fewer points met is noise
  int max_points = 200;       // ours: what the long window takes of it; more gain nothing
};

/// Depth points of a body over its keyframes, averaged in voxels of the body's frame. Bounded: voxels beyond
/// three radii are refused.
class SurfaceCloud {
 public:
  explicit SurfaceCloud(const SurfaceCloudOptions& options) : options_(options) {}

  /// Forgets everything and takes voxels for a body of this radius.
  void reset(double radius_m);
  /// `points` (3 x n) in the body's frame [m].
  void add(const Eigen::Matrix3Xd& points);
  /// At most max_points means of voxels with enough hits, spread evenly (3 x n).
  Eigen::Matrix3Xd sample() const;

 private:
  struct Voxel {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    int hits = 0;
  };
  SurfaceCloudOptions options_;
  double voxel_m_ = 0.01, reach_m_ = 1;
  std::map<std::array<int, 3>, Voxel> voxels_;
};

}  // namespace uniquadric
