#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// What an estimate says of one object's size over time, which needs no truth.
struct SizeSteadiness {
  int id = 0;                                             ///< of the estimated track
  std::size_t states = 0;                                 ///< at least 1
  Eigen::Vector3d semi_axes_m = Eigen::Vector3d::Zero();  ///< median over the states, axis by axis
  double spread = 0;  ///< root mean square over states and axes of (axis - median) / median
};

/// One entry for each track that has a state, in the order of the tracks.
std::vector<SizeSteadiness> size_steadiness(const std::vector<ObjectTrack>& tracks);

/// Mean spread of the tracks, each counted by its states; nothing where there is no track.
std::optional<double> mean_spread(const std::vector<SizeSteadiness>& sizes);

}  // namespace uniquadric
