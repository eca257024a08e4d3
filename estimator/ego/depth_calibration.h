#pragma once

#include <limits>
#include <optional>

#include "core/sequence/tracks.h"
#include "estimator/ego/ego_map.h"

namespace uniquadric {

/// What a stereo camera that is a little out of line adds to inverse depth: 1 / measured = 1 / z + bias.
struct DepthBias {
  double per_m = 0;        ///< [1/m]
  double sigma_per_m = 0;  ///< its standard deviation
};

/// The bias by which the map's points are seen most rigidly: bundle adjustment over an even choice of
/// keyframes and the points most seen, with the bias, the focal length and the principal point as unknowns.
/// The last two have priors, and take what would else be blamed on depth. `pixel_sigma` is a feature's [px].
/// A common scale of all depth cannot be seen. The sigma is the larger of two jackknives': over groups of
/// points, for a point's errors are alike in all its sightings, and over keyframes in a row, for errors of
/// tracking and of exposure hang together for a while. Nothing for fewer than four keyframes.
/// Nothing either, in a seventh of the time, where even points without such errors leave more than
/// `most_sigma_per_m`.
std::optional<DepthBias> calibrate_depth(const EgoMap& map, const Camera& camera, double pixel_sigma,
                                         double most_sigma_per_m = std::numeric_limits<double>::infinity());

/// Adds to a state's variances what a bias may be off by: depths that are off by z^2 sigma move a body along
/// its ray and change its size by the same share, z sigma.
void add_bias_variance(const DepthBias& bias, const Pose& world_from_camera, ObjectState& state);

}  // namespace uniquadric
