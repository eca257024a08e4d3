#pragma once

#include "simulator/scene/motion.h"

namespace uniquadric {

/// What a motion evaluates: one analytic formula of time. Every curve is twice differentiable (a spline: in
/// pieces, with continuous second derivative), so that velocity and acceleration can be read off the same
/// formula.
class Motion::Curve {
 public:
  virtual ~Curve() = default;
  virtual Pose at(double time_s) const = 0;
};

}  // namespace uniquadric
