#include "estimator/images/noise_correlation.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kLattice = 24;  // windows a row and a column of the lattice
constexpr std::size_t kLeastWindows = 30;
constexpr double kLongest_px = 10;  // longer than the windows tell
constexpr int kBisections = 20;

}  // namespace

WindowNoise window_noise(int half_px, double correlation_px) {
  if (!(correlation_px > 0)) return {};
  const double n = 2 * half_px + 1;
  double sum = 0, moment = 0, squares = 0;  // of the correlation in one row; of x
  for (int i = -half_px; i <= half_px; ++i) {
    squares += i * i;
    for (int j = -half_px; j <= half_px; ++j) {
      const double rho = std::exp(-(i - j) * (i - j) / (2 * correlation_px * correlation_px));
      sum += rho;
      moment += i * j * rho;
    }
  }
  const double mean = sum / n, slope = moment / squares;  // variances, of white noise 1
  const double residual = (n * n - mean * mean - 2 * slope * mean) / (n * n - 3);
  return {mean * mean / residual, slope * mean / residual, residual};
}

double noise_correlation_px(const cv::Mat& depth, const PlaneDepthOptions& options) {
  std::vector<double> ratios;
  for (int row = 1; row < kLattice; ++row)
    for (int column = 1; column < kLattice; ++column) {
      const Eigen::Vector2d pixel(column * depth.cols / kLattice, row * depth.rows / kLattice);
      if (const auto ratio = residual_ratio(depth, pixel, options)) ratios.push_back(*ratio);
    }
  if (ratios.size() < kLeastWindows) return 0;
  const double measured = quantile(std::move(ratios), 0.5);
  double low = 0, high = kLongest_px;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    const double expected = window_noise(options.half_window_px, middle).residual /
                            window_noise(options.half_wide_px, middle).residual;
    (expected > measured ? low : high) = middle;
  }
  return high < kLongest_px ? low : 0;
}

SurfaceNoise surface_noise(const cv::Mat& depth, const PlaneDepthOptions& options) {
  const double correlation_px = noise_correlation_px(depth, options);
  return {window_noise(options.half_window_px, correlation_px),
          window_noise(options.half_wide_px, correlation_px)};
}

}  // namespace uniquadric
