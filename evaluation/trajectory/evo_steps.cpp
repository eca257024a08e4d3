#include "evaluation/trajectory/evo_steps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr double kRadians = std::numbers::pi / 180;
constexpr double kMostAngle = std::numbers::pi;  // between two orientations
constexpr double kCosineRounding = 1e-9;         // far above that of a product of unit quaternions

double angle_between(const Pose& a, const Pose& b) {
  return rotation_angle((a.rotation.conjugate() * b.rotation).toRotationMatrix());
}

std::vector<IndexStep> steps_along_path(const std::vector<Pose>& poses, double delta_m) {
  std::vector<IndexStep> steps;
  std::size_t start = poses.size();  // none yet
  double path_m = 0;
  for (std::size_t j = 1; j < poses.size(); ++j) {
    path_m += (poses[j].translation - poses[j - 1].translation).norm();
    if (path_m < delta_m) continue;
    if (start < poses.size()) steps.push_back({start, j});
    start = j;
    path_m = 0;
  }
  return steps;
}

std::vector<IndexStep> steps_along_turns(const std::vector<Pose>& poses, double delta_rad) {
  std::vector<IndexStep> steps;
  std::size_t start = 0;
  double turned_rad = 0;
  for (std::size_t j = 1; j < poses.size(); ++j) {
    turned_rad += angle_between(poses[j - 1], poses[j]);
    if (turned_rad < delta_rad) continue;
    steps.push_back({start, j});
    start = j;
    turned_rad = 0;
  }
  return steps;
}

// Every pair of poses is looked at: the cosine of half the angle, a product of two quaternions, settles all
// that are not near the band.
std::vector<IndexStep> all_turns(const std::vector<Pose>& poses, double delta_rad, double tolerance_rad) {
  const double least_rad = delta_rad - tolerance_rad, most_rad = delta_rad + tolerance_rad;
  const double least_cosine = std::cos(std::min(most_rad, kMostAngle) / 2) - kCosineRounding;
  const double most_cosine = std::cos(least_rad / 2) + kCosineRounding;
  std::vector<IndexStep> steps;
  for (std::size_t i = 0; i < poses.size(); ++i)
    for (std::size_t j = i + 1; j < poses.size(); ++j) {
      const double cosine = std::abs(poses[i].rotation.dot(poses[j].rotation));
      if (cosine < least_cosine || cosine > most_cosine) continue;
      const double angle_rad = angle_between(poses[i], poses[j]);
      if (least_rad <= angle_rad && angle_rad <= most_rad) steps.push_back({i, j});
    }
  return steps;
}

}  // namespace

std::vector<IndexStep> evo_steps(const std::vector<Pose>& poses, const DeltaOptions& options) {
  if (options.unit == DeltaUnit::seconds) throw InputError("evo has no steps in seconds");
  const bool in_degrees = options.unit == DeltaUnit::degrees;
  if (in_degrees && options.delta > 180) throw InputError("delta in degrees must be at most 180");
  if (!(options.delta > 0) || options.unit == DeltaUnit::frames || (!in_degrees && options.all_pairs))
    return delta_steps(poses, std::vector<std::int64_t>(poses.size()), options);
  if (!in_degrees) return steps_along_path(poses, options.delta);
  const double delta_rad = options.delta * kRadians;
  return options.all_pairs ? all_turns(poses, delta_rad, options.tolerance * options.delta * kRadians)
                           : steps_along_turns(poses, delta_rad);
}

}  // namespace uniquadric
