#include "evaluation/iou/solid_iou.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "evaluation/iou/box_iou.h"
#include "evaluation/iou/ellipsoid_iou.h"

namespace uniquadric {
namespace {

using Replicates = std::array<double, kReplicates>;

double mean(const Replicates& values) {
  return std::accumulate(values.begin(), values.end(), 0.0) / kReplicates;
}

SolidIou exact(double iou) {
  SolidIou result{iou, {}, 0};
  result.replicates.fill(iou);
  return result;
}

bool is_same(const Solid& a, const Superellipsoid& b, const Pose& a_from_b) {
  return !a.mesh && a.body == b && a_from_b.translation.isZero(0) && a_from_b.rotation.vec().isZero(0);
}

std::optional<double> exact_iou(const Solid& a, const Superellipsoid& b, const Pose& a_from_b) {
  if (is_same(a, b, a_from_b)) return 1;
  if (a.mesh) return std::nullopt;
  const Ellipsoid first{{}, a.body.semi_axes_m}, second{a_from_b, b.semi_axes_m};
  if (is_box(a.body) && is_box(b)) return box_iou(first, second);
  if (is_ellipsoid(a.body) && is_ellipsoid(b)) return ellipsoid_iou(first, second);
  return std::nullopt;
}

// With I the common volume and V, W those of the bodies, IoU = I / (V + W - I), and its change is
// ((V + W) dI - I dV) / (V + W - I)^2. `count`: how many points are in the other body.
template <typename Count>
SolidIou sampled_iou(const SolidSamples& samples, double other_volume, const Count& count) {
  Replicates common{};
  for (std::size_t r = 0; r < kReplicates; ++r)
    if (const auto points = samples.points(r); !points.empty())
      common[r] = samples.volume(r) * static_cast<double>(count(points)) / static_cast<double>(points.size());
  const double I = mean(common), V = samples.volume(), both = V + std::max(other_volume, I);
  assert(V > 0);
  const double all = both - I, by_common = both / (all * all), by_volume = -I / (all * all);
  SolidIou result{I / all, {}, by_common * samples.volume_of_point()};
  for (std::size_t r = 0; r < kReplicates; ++r)
    result.replicates[r] = result.iou + by_common * (common[r] - I) + by_volume * (samples.volume(r) - V);
  return result;
}

}  // namespace

SolidSamples::SolidSamples(Solid solid, int candidates, std::uint64_t seed) : solid_(std::move(solid)) {
  assert(candidates > 0);
  const Eigen::AlignedBox3d box = bounding_box(solid_);
  if (box.isEmpty()) return;
  const std::size_t each = (static_cast<std::size_t>(candidates) + kReplicates - 1) / kReplicates;
  std::vector<Eigen::Vector3d> all;
  for (std::size_t r = 0; r < kReplicates; ++r)
    for (const Eigen::Vector3d& u :
         shifted_sequence(static_cast<int>(each), seed, "iou3d_solid", static_cast<int>(r)))
      all.emplace_back(box.min() + u.cwiseProduct(box.sizes()));
  const std::vector<char> inside = contains(solid_, all);
  volume_of_point_ = box.volume() / static_cast<double>(all.size());
  const std::optional<double> known = known_volume(solid_);
  for (std::size_t r = 0; r < kReplicates; ++r) {
    for (std::size_t i = r * each; i < (r + 1) * each; ++i)
      if (inside[i]) points_.push_back(all[i]);
    begins_[r + 1] = points_.size();
    volumes_[r] =
        known.value_or(box.volume() * static_cast<double>(points(r).size()) / static_cast<double>(each));
  }
}

std::span<const Eigen::Vector3d> SolidSamples::points(std::size_t replicate) const {
  return std::span(points_).subspan(begins_[replicate], begins_[replicate + 1] - begins_[replicate]);
}

double SolidSamples::volume() const {
  return mean(volumes_);
}

SolidIou solid_iou(const SolidSamples& samples, const Superellipsoid& other, const Pose& samples_from_other) {
  if (const auto iou = exact_iou(samples.solid(), other, samples_from_other)) return exact(*iou);
  const InsideTest test(other, samples_from_other);
  return sampled_iou(samples, superellipsoid_volume(other), [&](std::span<const Eigen::Vector3d> points) {
    return std::ranges::count_if(points, [&](const auto& point) { return test.contains(point); });
  });
}

SolidIou solid_iou(const SolidSamples& samples, const MeshSolid& other, double other_volume,
                   const Pose& samples_from_other) {
  const Pose other_from_samples = samples_from_other.inverse();
  return sampled_iou(samples, other_volume, [&](std::span<const Eigen::Vector3d> points) {
    std::vector<Eigen::Vector3d> moved;
    for (const Eigen::Vector3d& point : points) moved.push_back(other_from_samples * point);
    return std::ranges::count(other.contains(moved), 1);
  });
}

MeanIou mean_iou(std::span<const SolidIou> pairs) {
  assert(!pairs.empty());
  const double n = static_cast<double>(pairs.size());
  double sum = 0, of_point = 0;
  Replicates replicates{};
  for (const SolidIou& pair : pairs) {
    sum += pair.iou / n;
    of_point += pair.of_point / n;
    for (std::size_t r = 0; r < kReplicates; ++r) replicates[r] += pair.replicates[r] / n;
  }
  if (of_point == 0) return {sum, 0};
  const double middle = mean(replicates);
  double variance = 0;
  for (const double replicate : replicates)
    variance += (replicate - middle) * (replicate - middle) / (kReplicates * (kReplicates - 1.0));
  return {sum, replicates_error(variance, of_point)};
}

}  // namespace uniquadric
