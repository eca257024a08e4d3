#pragma once

#include <gtest/gtest.h>

#include <array>

#include "simulator/scene/motion.h"

namespace uniquadric::scene_test {

/// Derivatives at the middle of five values h apart, of fourth order.
inline Eigen::Vector3d rate(const std::array<Eigen::Vector3d, 5>& f, double h) {
  return (f[0] - 8 * f[1] + 8 * f[3] - f[4]) / (12 * h);
}
inline Eigen::Vector3d second_rate(const std::array<Eigen::Vector3d, 5>& f, double h) {
  return (-f[0] + 16 * f[1] - 30 * f[2] + 16 * f[3] - f[4]) / (12 * h * h);
}

/// Rotations are compared as rotation vectors relative to the middle one, whose first two derivatives there
/// are angular velocity and acceleration in the body frame.
inline void expect_derivatives(const Motion& motion, double time_s, double step_s, double rate_bound,
                               double acceleration_bound) {
  constexpr double kRounding = 1e-12;  // m, rad: a dozen operations on numbers of order one
  const Kinematics found = motion.kinematics(time_s);
  std::array<Eigen::Vector3d, 5> places, turns;
  for (int k = 0; k < 5; ++k) {
    const Pose pose = motion.at(time_s + (k - 2) * step_s);
    places[k] = pose.translation;
    turns[k] = log_so3(found.pose.rotation.conjugate() * pose.rotation);
  }
  EXPECT_LT((found.pose.translation - places[2]).norm(), kRounding) << time_s;
  EXPECT_LT(turns[2].norm(), kRounding) << time_s;
  EXPECT_LT((found.velocity_mps - rate(places, step_s)).norm(), rate_bound) << time_s;
  EXPECT_LT((found.acceleration_mps2 - second_rate(places, step_s)).norm(), acceleration_bound) << time_s;
  EXPECT_LT((found.angular_velocity_radps - rate(turns, step_s)).norm(), rate_bound) << time_s;
  EXPECT_LT((found.angular_acceleration_radps2 - second_rate(turns, step_s)).norm(), acceleration_bound)
      << time_s;
}

}  // namespace uniquadric::scene_test
