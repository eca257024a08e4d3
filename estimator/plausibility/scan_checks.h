#pragma once

#include <string>
#include <vector>

#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// What a few scans in a row show.
struct ScanMotion {
  std::vector<std::string> faults;  ///< of the points themselves
  bool have_times = true;           ///< of points within a scan
  /// The camera's motion as the scans have it, between frames where the sequence has some: points at 5 to 20
  /// m stand for the images.
  std::vector<FramePair> pairs;
};
ScanMotion scan_motion(const Sequence& sequence);

/// Whether scans turn as the gyroscope does, or would with the LiDAR in other axes or its place inverted.
std::vector<std::string> scan_turn_suspicions(const Sequence& sequence, const ScanMotion& motion);

}  // namespace uniquadric
