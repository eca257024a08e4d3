#include "estimator/shape/density_edge.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

namespace uniquadric {
namespace {

constexpr int kParts = 5;     // face, side, slope, bulge, floor
constexpr double kBin = 0.5;  // in sigmas
constexpr int kBelow = 24;    // bins below where the edge is looked for: 12 sigmas of the body
constexpr int kAbove = 10;    // and above: the noise's tail, then outliers alone
constexpr int kBins = kBelow + kAbove;
constexpr int kSweeps = 20;  // of the parts' shares
constexpr std::array<double, 5> kNoiseFactors = {0.5, 0.7, 1.0, 1.4, 2.0};
constexpr double kNoiseFactorSigma = 0.35;  // of its logarithm: how well a sensor's noise is known

constexpr double kLeast = 1e-6;  // points a bin, where the model has none
using Histogram = Eigen::Array<double, kBins, 1>;

double normal_density(double x) {
  return std::exp(-x * x / 2) * 0.3989422804014327;
}
double normal_above(double x) {
  return 0.5 * std::erfc(x * 0.7071067811865476);
}

// sqrt(depth) of the surface at u blurred by a unit normal, at x, by Simpson's rule.
double blurred_root(double x) {
  constexpr int kSteps = 48;
  constexpr double kStep = 8.0 / kSteps;
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double u = -4 + i * kStep;
    const double rule = i == 0 || i == kSteps ? 1 : (i % 2 ? 4 : 2);
    if (u > x) sum += rule * std::sqrt(u - x) * normal_density(u);
  }
  return sum * kStep / 3;
}

// The density of face, side and bulge at x sigmas above the edge.
struct PartTable {
  static constexpr double kLow = -25, kStep = 0.05;
  static constexpr int kSize = 901;  // to +20
  std::array<Eigen::Array3d, kSize> value;
  PartTable() {
    for (int i = 0; i < kSize; ++i) {
      const double x = kLow + i * kStep;
      value[i] = {normal_density(x), normal_above(x), blurred_root(x)};
    }
  }
  Eigen::Array3d at(double x) const {
    const double place = std::clamp((x - kLow) / kStep, 0.0, kSize - 1.001);
    const int i = static_cast<int>(place);
    return value[i] + (place - i) * (value[i + 1] - value[i]);
  }
};

// Counts of bins of half a noise sigma, from `low` up.
struct Window {
  Histogram counts = Histogram::Zero();
  double low = 0, bin_m = 0;
};

// Log likelihood of the window for an edge and a noise; the parts' shares maximise it too.
double log_likelihood(const Window& window, double edge, double noise_m) {
  static const PartTable table;
  Eigen::Array<double, kBins, kParts> parts;
  for (int j = 0; j < kBins; ++j) {
    const double x = window.low + (j + 0.5) * window.bin_m - edge;
    const Eigen::Array3d v = table.at(x / noise_m);
    const double rise = std::max(0.0, 1 + x / (kBelow * window.bin_m));
    parts.row(j) << v[0], v[1], v[1] * rise, v[2], 1;
  }
  for (int k = 0; k < kParts; ++k) parts.col(k) /= parts.col(k).sum() + 1e-12;
  Eigen::Array<double, kParts, 1> share =
      Eigen::Array<double, kParts, 1>::Constant(window.counts.sum() / kParts);
  Histogram model = (parts.matrix() * share.matrix()).array();
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (int k = 0; k < kParts; ++k) {
      // Newton's step in one share: the likelihood is concave in all of them.
      const auto part = parts.col(k);
      const Histogram ratio = window.counts / model.max(kLeast);
      const double slope = (part * (ratio - 1)).sum();
      const double curvature = (part.square() * ratio / model.max(kLeast)).sum() + 1e-12;
      const double next = std::max(share[k] + slope / curvature, 0.0);
      model += (next - share[k]) * part;
      share[k] = next;
    }
  model = model.max(kLeast);
  return (window.counts * model.log() - model).sum();
}

// Histogram of all coordinates from the lowest up; far outliers are gathered in the last bin.
std::vector<double> histogram(const Eigen::VectorXd& x, const Eigen::VectorXd& w, double bin_m) {
  constexpr double kMostBins = 4096;
  const double lowest = x.minCoeff();
  std::vector<double> bins(
      static_cast<std::size_t>(std::min((x.maxCoeff() - lowest) / bin_m + 1, kMostBins)));
  for (Eigen::Index i = 0; i < x.size(); ++i)
    bins[std::min(static_cast<std::size_t>((x[i] - lowest) / bin_m), bins.size() - 1)] += w[i];
  return bins;
}

// Weight a bin between the 5 % and the 95 % quantile.
double mean_density(const std::vector<double>& bins) {
  const double total = std::accumulate(bins.begin(), bins.end(), 0.0);
  double sum = 0;
  int within = 0;
  for (const double bin : bins) {
    sum += bin;
    if (sum - bin < 0.95 * total && sum > 0.05 * total) ++within;
  }
  return 0.9 * total / std::max(within, 1);
}

// The uppermost bin that is dense together with its neighbours; where a bin holds few points, a handful of
// them that lie together by chance is not taken for the body.
int dense_end(const std::vector<double>& bins, double mean, double share) {
  constexpr int kReach = 2;
  constexpr double kHandful = 5;
  const double whole = (2 * kReach + 1) * mean;
  const double needed = std::max(share * whole, std::min(kHandful, 0.6 * whole));
  for (int j = static_cast<int>(bins.size()) - 1; j > 0; --j) {
    double sum = 0;
    for (int i = std::max(j - kReach, 0); i <= std::min(j + kReach, static_cast<int>(bins.size()) - 1); ++i)
      sum += bins[i];
    if (sum > needed) return j;
  }
  return 0;
}

Window window_at_end(const Eigen::VectorXd& x, const Eigen::VectorXd& w, double noise_m,
                     double start_density) {
  Window window;
  window.bin_m = kBin * noise_m;
  const std::vector<double> bins = histogram(x, w, window.bin_m);
  const int first = dense_end(bins, mean_density(bins), start_density) - kBelow;
  for (int j = 0; j < kBins; ++j)
    if (first + j >= 0 && first + j < static_cast<int>(bins.size())) window.counts[j] = bins[first + j];
  window.low = x.minCoeff() + first * window.bin_m;
  return window;
}

// The most likely edge for a noise, by halving steps, with its likelihood and its error.
struct Candidate {
  double edge = 0, value = 0, variance = 0, noise_m = 0;
};

Candidate most_likely_edge(const Window& window, double noise_m, double factor) {
  Candidate c;
  c.noise_m = factor * noise_m;
  const auto at = [&](double edge) { return log_likelihood(window, edge, c.noise_m); };
  c.edge = window.low + kBelow * window.bin_m;
  c.value = at(c.edge);
  for (double step = 4 * window.bin_m; step > 0.04 * window.bin_m; step /= 2)
    for (const double next : {c.edge - step, c.edge + step})
      if (const double l = at(next); l > c.value) c.edge = next, c.value = l;
  const double d = 0.2 * noise_m;
  const double curvature = (2 * c.value - at(c.edge - d) - at(c.edge + d)) / (d * d);
  c.variance = 1 / std::max(curvature, 1 / (noise_m * noise_m));
  c.value -= std::pow(std::log(factor) / kNoiseFactorSigma, 2) / 2;
  return c;
}

// Mean over the noises: where they say different things of the edge, neither is to be believed alone.
DensityEdge mean_of(const std::array<Candidate, kNoiseFactors.size()>& candidates) {
  double best = candidates[0].value, sum = 0, square = 0;
  for (const Candidate& c : candidates) best = std::max(best, c.value);
  DensityEdge mean;
  for (const Candidate& c : candidates) {
    const double p = std::exp(c.value - best);
    sum += p;
    mean.position_m += p * c.edge;
    mean.noise_m += p * c.noise_m;
  }
  mean.position_m /= sum, mean.noise_m /= sum;
  for (const Candidate& c : candidates)
    square += std::exp(c.value - best) / sum * (c.variance + std::pow(c.edge - mean.position_m, 2));
  mean.sigma_m = std::sqrt(square);
  return mean;
}

}  // namespace

std::optional<DensityEdge> upper_edge(const Eigen::VectorXd& coordinates, const Eigen::VectorXd& weights,
                                      double noise_m, const DensityEdgeOptions& options) {
  if (coordinates.size() == 0 || weights.sum() < options.min_weight) return std::nullopt;
  const Window window = window_at_end(coordinates, weights, noise_m, options.start_density);
  std::array<Candidate, kNoiseFactors.size()> candidates;
  for (std::size_t i = 0; i < candidates.size(); ++i)
    candidates[i] = most_likely_edge(window, noise_m, kNoiseFactors[i]);
  return mean_of(candidates);
}

}  // namespace uniquadric
