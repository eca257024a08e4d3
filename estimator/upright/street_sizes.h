#pragma once

#include <Eigen/Core>
#include <array>

namespace uniquadric {

/// What was seen of a body's size: length, width and height [m], each at least so much.
struct SeenSize {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d sigma_m = Eigen::Vector3d::Zero();
  Eigen::Vector3d beyond_m = Eigen::Vector3d::Zero();  ///< that it may be larger by, between two beams
  std::array<bool, 3> is_whole{};                      ///< whether it is not only a part
  double speed_mps = 0;
};

struct SizeBelief {
  Eigen::Vector3d size_m = Eigen::Vector3d::Zero(), sigma_m = Eigen::Vector3d::Zero();
  double misfit = 0;  ///< -2 ln of how likely it is to see this of a street user, but for a constant
};

/// Length, width and height of a street user of which that was seen: the mixture of cars, vans, trucks,
/// trams, cyclists and pedestrians that could be it. Mean sizes are those of KITTI's training labels (Geiger
/// et al., CVPR 2012) as Frustum PointNets lists them (Qi et al., CVPR 2018); spreads, shares and speeds are
/// ours.
SizeBelief street_size(const SeenSize& seen);

}  // namespace uniquadric
