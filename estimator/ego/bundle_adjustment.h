#pragma once

#include <vector>

#include "estimator/ego/ego_map.h"

namespace uniquadric {

/// All numbers are ours.
struct BundleOptions {
  double pixel_sigma = 0.15;  // of an aligned feature [px]
  double huber_sigmas = 2;    // beyond which a residual counts linearly
  double outlier_sigmas = 6;  // of a sighting that is taken out afterwards
  int iterations = 8;         // of a window: it starts near its minimum
};

/// Moves the keyframes of `moving` and all points that they see to the least sum of robust reprojection and
/// depth residuals (Schur complement, one thread: the same bits each time). Other keyframes that see these
/// points hold still; where there is none, the first of `moving` does. Sightings that fit badly afterwards
/// are taken out of the map.
void adjust_bundle(EgoMap& map, const Camera& camera, const std::vector<int>& moving,
                   const BundleOptions& options);

}  // namespace uniquadric
