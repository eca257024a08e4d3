#pragma once

#include "estimator/factors/pose_jacobian.h"

namespace uniquadric {

/// Of Gauss-Newton over a right-hand perturbation (translation, rotation vector) of a pose.
struct NormalEquations {
  Matrix6d information = Matrix6d::Zero();
  Vector6d gradient = Vector6d::Zero();
};

}  // namespace uniquadric
