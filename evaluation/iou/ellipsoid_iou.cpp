#include "evaluation/iou/ellipsoid_iou.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "evaluation/iou/disc_ellipse.h"
#include "evaluation/iou/gauss_legendre.h"
#include "evaluation/iou/stationary_slices.h"
#include "evaluation/iou/whitened_pair.h"

namespace uniquadric {
namespace {

using std::numbers::pi;
constexpr double kBallVolume = 4 * pi / 3;
// Of the ball's volume, a segment: where two rules differ by less, the finer one is right to 1e-9 (it
// converges exponentially).
constexpr double kTolerance = 2e-8;
constexpr int kMaxDepth = 12;         // halvings of a segment
constexpr int kMaxTopologyDepth = 8;  // beyond it rounding, not topology, changes between slices
constexpr int kBisections = 18;  // a break that is off by w costs w^2.5: 1e-6 of a node distance is enough
constexpr int kScanSlices = 24;  // that look for topology changes before any quadrature

class SliceIntegral {
 public:
  explicit SliceIntegral(const WhitenedPair& pair)
      : pair_(pair), stationary_(stationary_slices(pair.center, pair.semi_axes)) {}

  double volume() const {
    const double low = std::max(-1.0, pair_.center.z() - pair_.semi_axes.z());
    const double high = std::min(1.0, pair_.center.z() + pair_.semi_axes.z());
    if (!(low < high)) return 0;
    std::vector<Slice> slices;
    for (int i = 0; i < kScanSlices; ++i) {
      const double z = (low + high) / 2 - (high - low) / 2 * std::cos(pi * (i + 0.5) / kScanSlices);
      slices.push_back({z, at(z).overlap});
    }
    for (const double z : stationary_)
      if (low < z && z < high) slices.push_back({z, at(z).overlap});
    return between_changes(low, high, slices, 0);
  }

 private:
  struct Slice {
    double z;
    DiscOverlap overlap;
  };

  DiscIntersection at(double z) const {
    const double u = (z - pair_.center.z()) / pair_.semi_axes.z();
    const double disc = (1 - z) * (1 + z), ellipse = (1 - u) * (1 + u);
    if (!(disc > 0) || !(ellipse > 0)) return {};
    const double radius = std::sqrt(disc);
    DiscIntersection result = intersect_unit_disc(pair_.center.head<2>() / radius,
                                                  pair_.semi_axes.head<2>() * std::sqrt(ellipse) / radius);
    result.area *= disc;
    return result;
  }

  // Parts [low, high] where the overlap changes between the slices and integrates the parts.
  double between_changes(double low, double high, std::vector<Slice>& slices, int depth) const {
    std::sort(slices.begin(), slices.end(), [](const Slice& a, const Slice& b) { return a.z < b.z; });
    double sum = 0;
    double begin = low;
    for (std::size_t i = 0; i + 1 < slices.size(); ++i) {
      if (slices[i].overlap == slices[i + 1].overlap) continue;
      const double end = change_between(slices[i], slices[i + 1]);
      if (slices[i].overlap != DiscOverlap::disjoint) sum += integrate(begin, end, depth + 1);
      begin = end;
    }
    return sum + (slices.back().overlap != DiscOverlap::disjoint ? integrate(begin, high, depth + 1) : 0);
  }

  double change_between(const Slice& left, const Slice& right) const {
    double low = left.z, high = right.z;
    for (int i = 0; i < kBisections; ++i) {
      const double middle = (low + high) / 2;
      (at(middle).overlap == left.overlap ? low : high) = middle;
    }
    return (low + high) / 2;
  }

  // z = middle - half cos(angle): the volume's derivatives of half-integer order at the ends become smooth in
  // the angle, so that the rules converge exponentially.
  double apply(const QuadratureRule& rule, double low, double high, std::vector<Slice>& slices) const {
    double sum = 0;
    for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
      const double angle = pi * (rule.nodes[i] + 1) / 2;
      const double z = (low + high) / 2 - (high - low) / 2 * std::cos(angle);
      const DiscIntersection slice = at(z);
      slices.push_back({z, slice.overlap});
      sum += rule.weights[i] * std::sin(angle) * slice.area;
    }
    return sum * pi / 2 * (high - low) / 2;
  }

  double integrate(double low, double high, int depth) const {
    static const QuadratureRule coarse_rule = gauss_legendre(10), fine_rule = gauss_legendre(16);
    if (!(low < high)) return 0;
    std::vector<Slice> slices;
    const double coarse = apply(coarse_rule, low, high, slices);
    const double fine = apply(fine_rule, low, high, slices);
    if (std::abs(fine - coarse) <= kTolerance || depth >= kMaxDepth) return fine;
    const bool changes = std::any_of(slices.begin(), slices.end(),
                                     [&](const Slice& slice) { return slice.overlap != slices[0].overlap; });
    if (changes && depth < kMaxTopologyDepth) return between_changes(low, high, slices, depth);
    const double middle = (low + high) / 2;
    return integrate(low, middle, depth + 1) + integrate(middle, high, depth + 1);
  }

  const WhitenedPair& pair_;
  std::vector<double> stationary_;
};

}  // namespace

double ellipsoid_iou(const Ellipsoid& a, const Ellipsoid& b) {
  const double distance_m = (a.world_from_object.translation - b.world_from_object.translation).norm();
  if (distance_m > a.semi_axes_m.maxCoeff() + b.semi_axes_m.maxCoeff()) return 0;
  const WhitenedPair pair = whiten(a, b);
  if (pair.identical) return 1;
  const double common = SliceIntegral(pair).volume() / kBallVolume;
  const double all = 1 + pair.volume_ratio() - common;
  return std::clamp(common / all, 0.0, 1.0);
}

}  // namespace uniquadric
