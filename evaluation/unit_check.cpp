#include "evaluation/unit_check.h"

#include <fmt/format.h>

#include <cmath>

#include "evaluation/statistics/statistics.h"

namespace uniquadric {
namespace {

std::optional<std::string> fault(const char* what, double estimate_m, double reference_m) {
  const bool apart = estimate_m > kUnitRatio * reference_m || reference_m > kUnitRatio * estimate_m;
  if (!(estimate_m > 0 && reference_m > 0) || !apart) return std::nullopt;
  return fmt::format(
      "{} {:.3g} m, the true ones {:.3g} m: is it in metres? --align sim3 or scale fits a factor", what,
      estimate_m, reference_m);
}

double spread_m(const std::vector<Pose>& poses) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) mean += pose.translation / static_cast<double>(poses.size());
  double squares = 0;
  for (const Pose& pose : poses) squares += (pose.translation - mean).squaredNorm();
  return poses.empty() ? 0 : std::sqrt(squares / static_cast<double>(poses.size()));
}

}  // namespace

double median_semi_axis_m(const std::vector<ObjectTrack>& tracks) {
  std::vector<double> semi_axes_m;
  for (const ObjectTrack& track : tracks)
    for (const ObjectState& state : track.states)
      for (const double a : state.ellipsoid.semi_axes_m) semi_axes_m.push_back(a);
  return semi_axes_m.empty() ? 0 : interpolated_quantile(std::move(semi_axes_m), 0.5);
}

std::optional<std::string> spread_fault(const std::vector<Pose>& reference,
                                        const std::vector<Pose>& estimate) {
  constexpr double kStill_m = 1e-9;  // rounding alone: a camera that stands still has no scale
  const double true_m = spread_m(reference);
  return true_m < kStill_m ? std::nullopt : fault("positions spread over", spread_m(estimate), true_m);
}

std::optional<std::string> size_fault(const std::vector<ObjectTrack>& truth,
                                      const std::vector<ObjectTrack>& estimate) {
  return fault("no object overlaps a true one; the semi-axes' median is", median_semi_axis_m(estimate),
               median_semi_axis_m(truth));
}

}  // namespace uniquadric
