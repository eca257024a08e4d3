#include "simulator/scene/motion.h"

#include "simulator/scene/curve.h"
#include "simulator/scene/named_motions.h"

namespace uniquadric {

// p_c = p_b + R_b q, R_c = R_b S, differentiated twice.
Kinematics operator*(const Kinematics& a, const Kinematics& b) {
  const Eigen::Quaterniond& R = a.pose.rotation;
  const Eigen::Vector3d &w = a.angular_velocity_radps, &q = b.pose.translation;
  const Eigen::Vector3d w_in_c = b.pose.rotation.conjugate() * w;
  Kinematics c;
  c.pose = a.pose * b.pose;
  c.velocity_mps = a.velocity_mps + R * (w.cross(q) + b.velocity_mps);
  c.acceleration_mps2 =
      a.acceleration_mps2 + R * (a.angular_acceleration_radps2.cross(q) + w.cross(w.cross(q)) +
                                 2 * w.cross(b.velocity_mps) + b.acceleration_mps2);
  c.angular_velocity_radps = w_in_c + b.angular_velocity_radps;
  c.angular_acceleration_radps2 = b.pose.rotation.conjugate() * a.angular_acceleration_radps2 +
                                  w_in_c.cross(b.angular_velocity_radps) + b.angular_acceleration_radps2;
  return c;
}

Motion::Motion() : Motion(static_motion(Pose())) {}

Motion::Motion(std::shared_ptr<const Curve> curve) : curve_(std::move(curve)) {}

Pose Motion::at(double time_s) const {
  return curve_->at(time_s);
}

Kinematics Motion::kinematics(double time_s) const {
  return curve_->kinematics(time_s);
}

}  // namespace uniquadric
