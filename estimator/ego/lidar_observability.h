#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/ego/lidar_filter.h"

namespace uniquadric {

/// All numbers are ours: in bare tunnels and over bare planes the ratio is 1 to 20 and nothing faces their
/// axis; on subway_car 5 and more of the place along the street, 40 and more of the turn, and 10 points face
/// it.
struct ObservabilityOptions {
  static constexpr double min_ratio = 30;  // of what is told to what errors of the planes' normals would tell
  double min_cosine = 0.5;                 // of a plane that faces a direction
  static constexpr int min_cells =
      8;  // of a plane that counts as facing: with fewer it may be one ring of a spinning
          // sensor where it goes round a tunnel's edge, which travels along with it
  static constexpr int min_facing = 10;  // points on such planes are enough without the ratio
};

/// What a sweep tells of the state, without what it only feigns to tell: the normals of a map's planes err by
/// some thousandths, and thousands of points on them would tell the place along a bare tunnel to centimetres.
/// `noise` is the part of normal.square that such errors make: the sum of weight A^T S A, A being the
/// derivative of a point's row of the Jacobian by its plane's normal and S the normal's covariance.
/// Along each main direction of the place (in the world), and of the turn (in the body), nothing is told
/// where the whole is not min_ratio times the noise (nor does any plane face it), nor of velocity and turn
/// rate. After Zhang, Kaess and Singh, "On degeneracy of optimization-based state estimation problems", ICRA
/// 2016, whose limit is one of eigenvalues, and Tuna et al., "X-ICP", IEEE T-RO 2024, who count what faces a
/// direction.
LidarNormal without_feigned(const LidarNormal& normal, const SightingSquare& noise,
                            const std::vector<Eigen::Vector3d>& plane_normals,
                            const ObservabilityOptions& options);

/// What a sweep tells where no IMU does: errors of velocity and turn rate bend the sweeps that became map,
/// and the next ones alike, which fit. So the motion that a sweep shows by itself counts as off by an error
/// of these standard deviations, which is eliminated from the sums. Without it that motion and the one from
/// place to place part, until the map is left.
LidarNormal with_bent_map(const LidarNormal& normal, double velocity_mps, double turn_rate_radps);

}  // namespace uniquadric
