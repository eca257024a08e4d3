#pragma once

#include <Eigen/Core>
#include <memory>

#include "core/geometry/pose.h"

namespace uniquadric {

/// A smooth trajectory through SE(3): world_from_body as a function of time.
class Motion {
 public:
  class Curve;
  Motion();  ///< at rest at the world's origin
  explicit Motion(std::shared_ptr<const Curve> curve);

  /// Pose at `time_s` [s] from the sequence's start; defined for every time (clamped outside its way-points).
  Pose at(double time_s) const;

 private:
  std::shared_ptr<const Curve> curve_;
};

}  // namespace uniquadric
