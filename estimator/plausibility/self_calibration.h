#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// The intrinsics with which points with depth move most rigidly.
struct SelfCalibration {
  double log_fx = 0, log_fy = 0;  ///< logarithm of the focal length over the one that is stated
  double cx_px = 0, cy_px = 0;    ///< less the stated ones
  Eigen::Vector4d sigma = Eigen::Vector4d::Zero();  ///< of these four in turn
};

/// Joint least squares over the pairs' motions and the intrinsics, robust. Nothing where the pairs do not
/// say.
std::optional<SelfCalibration> self_calibrate(const Camera& camera,
                                              const std::vector<const FramePair*>& pairs);

}  // namespace uniquadric
