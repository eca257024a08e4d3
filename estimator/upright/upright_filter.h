#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/upright/street_sizes.h"
#include "estimator/upright/upright_options.h"
#include "estimator/upright/upright_sight.h"

namespace uniquadric {

/// Of a body on the ground: place of its middle, yaw, speed along it, yaw rate; length, width and height.
enum UprightEntry { kX, kY, kYaw, kSpeed, kYawRate, kLength, kWidth, kHeight, kUprightEntries };
using UprightVector = Eigen::Matrix<double, kUprightEntries, 1>;
using UprightMatrix = Eigen::Matrix<double, kUprightEntries, kUprightEntries>;

struct UprightState {
  std::int64_t frame = 0, stamp_ns = 0;
  UprightVector mean = UprightVector::Zero();
  UprightMatrix covariance = UprightMatrix::Identity();
  double bottom_m = 0;   ///< z of the ground under it
  bool is_seen = false;  ///< not predicted alone
};

/// A frame, with what it shows of a body or nothing.
struct UprightFrame {
  std::int64_t frame = 0, stamp_ns = 0;
  std::optional<UprightSight> sight;
};

/// An extended Kalman filter over a body that moves along its own yaw with a turn rate (CTRV). What it
/// measures are the ends of the body: those in view tell the middle and the size, those that are hidden only
/// how large it is at least. So the side that is seen stays where it is while the size becomes known.
class UprightFilter {
 public:
  explicit UprightFilter(const UprightBoxOptions& options) : options_(options) {}

  /// With the velocity [m/s] that the body was tracked with.
  void start(const UprightSight& sight, const Eigen::Vector2d& velocity_mps);
  /// Goes on to a frame; null: the body was not seen in it.
  void step(std::int64_t frame, std::int64_t stamp_ns, const UprightSight* sight);

  /// As known at each frame.
  std::vector<UprightState> causal() const;
  /// As known `lag_ns` after each frame, or at the end. After start().
  std::vector<UprightState> smoothed(std::int64_t lag_ns) const;
  /// Where the body was in earlier frames, in their order, from a state on that all later ones have told.
  std::vector<UprightState> before(const UprightState& first, const std::vector<UprightFrame>& frames);

 private:
  // A number that was measured, less what was expected: from `low` to `high`, with a sigma of both.
  struct Seen {
    double low = 0, high = 0, sigma = 0;
  };
  struct Step {
    UprightState now;
    UprightVector predicted = UprightVector::Zero();
    UprightMatrix predicted_covariance = UprightMatrix::Identity(), transition = UprightMatrix::Identity();
  };
  /// A step's state as it is known by the one after it (Rauch, Tung and Striebel).
  UprightState looked_back(std::size_t step, const UprightState& later) const;
  SizeBelief expected_size(const UprightSight& sight, const UprightState& state) const;
  SizeBelief turn_along_length(const UprightSight& sight, UprightState& state) const;
  Step gone_on(const UprightState& from, std::int64_t frame, std::int64_t stamp_ns) const;
  void see(const UprightSight& sight, UprightState& state);
  bool measure(const UprightVector& row, const Seen& seen, UprightState& state) const;
  static void doubt(const UprightVector& row, double innovation, UprightState& state);

  UprightBoxOptions options_;
  std::vector<Step> steps_;
  std::array<int, 4> scans_off_{};  // in which each end was not where it was expected
};

}  // namespace uniquadric
