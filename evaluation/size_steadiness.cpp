#include "evaluation/size_steadiness.h"

#include <cmath>

#include "evaluation/statistics/statistics.h"

namespace uniquadric {
namespace {

std::vector<double> axis_lengths(const ObjectTrack& track, int axis) {
  std::vector<double> lengths_m;
  for (const ObjectState& state : track.states) lengths_m.push_back(state.ellipsoid.semi_axes_m[axis]);
  return lengths_m;
}

SizeSteadiness steadiness_of(const ObjectTrack& track) {
  SizeSteadiness size{track.id, track.states.size(), Eigen::Vector3d::Zero(), 0};
  double sum = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<double> lengths_m = axis_lengths(track, axis);
    const double median_m = size.semi_axes_m[axis] = statistics(lengths_m)->median;
    for (const double length_m : lengths_m) sum += std::pow(length_m / median_m - 1, 2);
  }
  size.spread = std::sqrt(sum / (3 * static_cast<double>(size.states)));
  return size;
}

}  // namespace

std::vector<SizeSteadiness> size_steadiness(const std::vector<ObjectTrack>& tracks) {
  std::vector<SizeSteadiness> sizes;
  for (const ObjectTrack& track : tracks)
    if (!track.states.empty()) sizes.push_back(steadiness_of(track));
  return sizes;
}

std::optional<double> mean_spread(const std::vector<SizeSteadiness>& sizes) {
  double sum = 0, states = 0;
  for (const SizeSteadiness& size : sizes) {
    sum += size.spread * static_cast<double>(size.states);
    states += static_cast<double>(size.states);
  }
  return states > 0 ? std::optional(sum / states) : std::nullopt;
}

}  // namespace uniquadric
