#pragma once

#include <vector>

#include "simulator/scene/contact.h"
#include "simulator/scene/toss.h"

namespace uniquadric {

inline constexpr double kFlightStep_s = 2.5e-4;  ///< ours: the body moves 1 mm in it at 4 m/s

/// The simulation behind a toss, one state a step from the release to the rest.
class Flight {
 public:
  struct Sample {
    Pose pose;
    Eigen::Vector3d velocity_mps, angular_velocity_radps;  ///< in the world; in the body
  };

  /// Throws InputError when the body starts below the plane.
  Flight(const TossOptions& options, const std::vector<Eigen::Vector3d>& points);
  std::vector<Sample> simulate();

 private:
  void step();
  void turn();
  std::vector<Contact> contacts(const Twist& twist) const;
  Eigen::Vector3d angular_velocity() const;
  bool is_slow(const std::vector<Contact>& contacts) const;
  Sample sample() const;

  const TossOptions& options_;
  const std::vector<Eigen::Vector3d>& points_;
  Eigen::Vector3d inertia_;  ///< about the body's axes, for mass 1
  double radius_m_ = 0;      ///< of the farthest point
  Pose pose_;
  Eigen::Vector3d velocity_mps_, momentum_;  ///< in the world; angular momentum for mass 1
  double slow_s_ = 0;
};

}  // namespace uniquadric
