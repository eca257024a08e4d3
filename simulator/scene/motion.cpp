#include "simulator/scene/motion.h"

#include "simulator/scene/curve.h"
#include "simulator/scene/named_motions.h"

namespace uniquadric {

Motion::Motion() : Motion(static_motion(Pose())) {}

Motion::Motion(std::shared_ptr<const Curve> curve) : curve_(std::move(curve)) {}

Pose Motion::at(double time_s) const {
  return curve_->at(time_s);
}

}  // namespace uniquadric
