#include "estimator/shape/axis_fusion.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

// One axis of all frames.
struct Samples {
  Eigen::ArrayXd value, sigma;
};

struct Fused {
  double value = 0, sigma = 0;
};

double median(Eigen::ArrayXd v) {
  std::sort(v.begin(), v.end());
  const Eigen::Index n = v.size();
  return n % 2 ? v[n / 2] : (v[n / 2 - 1] + v[n / 2]) / 2;
}

// Where half the weight is reached, between two values halfway if that is between them.
double weighted_median(const Eigen::ArrayXd& v, const Eigen::ArrayXd& weight) {
  std::vector<Eigen::Index> order(static_cast<std::size_t>(v.size()));
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](auto a, auto b) { return v[a] < v[b]; });
  const double half = weight.sum() / 2, tie = 1e-9 * weight.sum();
  double below = 0;
  for (std::size_t i = 0; i < order.size(); ++i) {
    below += weight[order[i]];
    if (std::abs(below - half) < tie && i + 1 < order.size()) return (v[order[i]] + v[order[i + 1]]) / 2;
    if (below > half) return v[order[i]];
  }
  return v[order.back()];
}

double spread(const Eigen::ArrayXd& v, double center) {
  return kMadToSigma * median((v - center).abs());
}

// Weighted mean with its standard error from the scatter the weights leave.
Fused weighted_mean(const Eigen::ArrayXd& value, const Eigen::ArrayXd& weight) {
  const double sum = weight.sum(), mean = (weight * value).sum() / sum;
  return {mean, std::sqrt((weight.square() * (value - mean).square()).sum()) / sum};
}

// sqrt(pi / 2): the median's error over the mean's.
Fused fuse_median(const Samples& s) {
  const double center = median(s.value);
  return {center, 1.2533 * spread(s.value, center) / std::sqrt(static_cast<double>(s.value.size()))};
}

// Standard error of the root of sum_i weight_i difference_i, whose weights change with the root too.
double mode_sigma(const Eigen::ArrayXd& difference, const Eigen::ArrayXd& variance,
                  const Eigen::ArrayXd& weight) {
  const double slope = (weight * (1 - difference.square() / variance)).sum();
  const double least = 0.1 * weight.sum();  // a flat top, between two modes
  return std::sqrt((weight * difference).square().sum()) / std::max(slope, least);
}

Fused fuse_renyi(const Samples& s, const AxisFusionOptions& options) {
  const double n = static_cast<double>(s.value.size());
  const Eigen::ArrayXd trust =
      options.weighted_spread ? s.sigma.square().inverse().eval() : Eigen::ArrayXd::Ones(s.sigma.size());
  double mode = weighted_median(s.value, trust);
  const double h =
      options.bandwidth * kMadToSigma * weighted_median((s.value - mode).abs(), trust) * std::pow(n, -0.2);
  const Eigen::ArrayXd variance = s.sigma.square() + h * h;
  const Eigen::ArrayXd p = (-s.sigma / (2 * median(s.sigma))).exp();
  // The density's gradient vanishes where a is the mean of the A_i under p_i N_i(a) / variance_i.
  const auto pull = [&](double a) -> Eigen::ArrayXd {
    return p * (-(s.value - a).square() / (2 * variance)).exp() / (variance * variance.sqrt());
  };
  for (int i = 0; i < options.iterations; ++i) {
    const Eigen::ArrayXd weight = pull(mode);
    const double next = (weight * s.value).sum() / weight.sum();
    if (std::abs(next - mode) < 1e-9) break;  // m
    mode = next;
  }
  return {mode, mode_sigma(s.value - mode, variance, pull(mode))};
}

double literal_fusion(const Samples& s, double alpha) {
  const Eigen::ArrayXd p = (-s.sigma / 2).exp();
  return std::log((p.pow(alpha) * s.value.exp()).sum()) / (1 - alpha);
}

Fused fuse_literal(const Samples& s, const AxisFusionOptions& options) {
  constexpr double kDifference = 1e-6;
  double alpha = options.literal_alpha;
  for (int i = 0; i < options.iterations; ++i) {
    const double slope = -(literal_fusion(s, alpha + kDifference) - literal_fusion(s, alpha - kDifference)) /
                         (2 * kDifference);
    alpha -= options.literal_step * slope;
  }
  return {literal_fusion(s, alpha), weighted_mean(s.value, Eigen::ArrayXd::Ones(s.value.size())).sigma};
}

Fused fuse(const Samples& s, const AxisFusionOptions& options) {
  switch (options.rule) {
    case AxisFusion::mean:
      return weighted_mean(s.value, Eigen::ArrayXd::Ones(s.value.size()));
    case AxisFusion::median:
      return fuse_median(s);
    case AxisFusion::inverse_variance:
      return weighted_mean(s.value, s.sigma.square().inverse());
    case AxisFusion::literal:
      return fuse_literal(s, options);
    case AxisFusion::renyi:
      break;
  }
  return fuse_renyi(s, options);
}

}  // namespace

std::optional<AxisEstimate> fuse_axes(std::span<const AxisEstimate> frames,
                                      const AxisFusionOptions& options) {
  if (frames.empty()) return std::nullopt;
  const auto n = static_cast<Eigen::Index>(frames.size());
  AxisEstimate result;
  for (int axis = 0; axis < 3; ++axis) {
    Samples s{Eigen::ArrayXd(n), Eigen::ArrayXd(n)};
    for (Eigen::Index i = 0; i < n; ++i) {
      s.value[i] = frames[static_cast<std::size_t>(i)].semi_axes_m[axis];
      s.sigma[i] = std::max(frames[static_cast<std::size_t>(i)].sigma_m[axis], options.min_sigma_m);
    }
    const Fused fused = fuse(s, options);
    if (!std::isfinite(fused.value)) return std::nullopt;
    result.semi_axes_m[axis] = fused.value;
    // No rule knows more than the frames say of themselves; one frame has no scatter, its own sigma stands.
    result.sigma_m[axis] = std::max(fused.sigma, 1 / std::sqrt(s.sigma.square().inverse().sum()));
  }
  return result;
}

}  // namespace uniquadric
