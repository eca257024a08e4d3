#pragma once

namespace uniquadric {

/// Bodies that stand upright on the ground, as all that drives or walks does. All numbers are ours.
struct UprightBoxOptions {
  double acceleration_mps2 = 3;                            // of a body: brakes and bends
  static constexpr double turn_acceleration_radps2 = 0.5;  // the same of its yaw
  static constexpr double gate_sigmas = 4;  // of an end or a yaw; beyond, it is another thing's
  double lost_after_s = 0.8;                // of prediction alone
  bool shape_yaw = true;                    // whether sides that are seen tell the yaw, too, or the way alone
  bool street_sizes = true;                 // whether what is hidden is as large as street users mostly are
  bool beam_gaps = true;  // whether it may end anywhere before the next beam, which missed it
};

}  // namespace uniquadric
