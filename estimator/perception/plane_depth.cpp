#include "estimator/perception/plane_depth.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace uniquadric {
namespace {

constexpr int kRounds = 3;  // of fit and rejection
constexpr double kMadToSigma = 1.4826;
constexpr double kCutVariance =
    1.03;                       // a normal distribution cut at three sigma has lost this of its variance
constexpr int kMinSamples = 8;  // three unknowns and a spread that means something

struct Sample {
  Eigen::Vector2d offset;  // from the pixel
  double inverse_depth;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + values.size() / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

std::vector<Sample> samples_about(const cv::Mat& depth, const cv::Mat& labels, const Eigen::Vector2d& pixel,
                                  int half) {
  const int cu = static_cast<int>(std::lround(pixel.x())), cv = static_cast<int>(std::lround(pixel.y()));
  if (cu < 0 || cv < 0 || cu >= depth.cols || cv >= depth.rows) return {};
  const auto label_at = [&](int u, int v) { return labels.empty() ? 0 : labels.at<std::uint16_t>(v, u); };
  const int label = label_at(cu, cv);
  std::vector<Sample> samples;
  samples.reserve((2 * half + 1) * (2 * half + 1));
  for (int v = std::max(cv - half, 0); v <= std::min(cv + half, depth.rows - 1); ++v)
    for (int u = std::max(cu - half, 0); u <= std::min(cu + half, depth.cols - 1); ++u) {
      const float z = depth.at<float>(v, u);
      if (z > 0 && label_at(u, v) == label) samples.push_back({Eigen::Vector2d(u, v) - pixel, 1.0 / z});
    }
  return samples;
}

// Leaves what lies within a jump of the median of the samples beside the pixel: the surface that the feature
// is on, when an edge runs through the window.
void keep_near_surface(std::vector<Sample>& samples, double max_jump) {
  std::vector<double> central;
  for (const auto& s : samples)
    if (s.offset.cwiseAbs().maxCoeff() < 2) central.push_back(s.inverse_depth);
  if (central.size() < 4) return samples.clear();
  const double middle = median(central);
  std::erase_if(samples, [&](const Sample& s) { return std::abs(s.inverse_depth / middle - 1) > max_jump; });
}

struct Fit {
  Eigen::Vector3d plane;  // w0, slope
  Eigen::Matrix3d inverse_normal_matrix;
};

std::optional<Fit> least_squares(const std::vector<Sample>& samples) {
  Eigen::Matrix3d N = Eigen::Matrix3d::Zero();
  Eigen::Vector3d b = Eigen::Vector3d::Zero();
  for (const auto& s : samples) {
    const Eigen::Vector3d row(1, s.offset.x(), s.offset.y());
    N += row * row.transpose();
    b += row * s.inverse_depth;
  }
  const Eigen::LDLT<Eigen::Matrix3d> solver(N);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-3)) return std::nullopt;
  return Fit{solver.solve(b), solver.solve(Eigen::Matrix3d::Identity())};
}

double residual(const Sample& s, const Eigen::Vector3d& plane) {
  return s.inverse_depth - plane[0] - plane.tail<2>().dot(s.offset);
}

// The plane of a window's samples in inverse depth, by rejection of outliers.
std::optional<PlaneDepth> robust_plane(std::vector<Sample> samples, int half,
                                       const PlaneDepthOptions& options) {
  const double side = 2 * half + 1;
  const std::size_t needed = std::max<std::size_t>(kMinSamples, std::lround(options.min_share * side * side));
  std::vector<double> spread;
  std::optional<Fit> fit;
  for (int round = 0; round < kRounds; ++round) {
    if (samples.size() < needed) return std::nullopt;
    fit = least_squares(samples);
    if (!fit || round + 1 == kRounds) break;
    spread.clear();
    for (const auto& s : samples) spread.push_back(std::abs(residual(s, fit->plane)));
    const double limit = std::max(options.outlier_sigmas * kMadToSigma * median(spread), 1e-9);
    std::erase_if(samples, [&](const Sample& s) { return std::abs(residual(s, fit->plane)) > limit; });
  }
  if (!fit || !(fit->plane[0] > 0)) return std::nullopt;
  double sum = 0;
  for (const auto& s : samples) sum += std::pow(residual(s, fit->plane), 2);
  const double variance = kCutVariance * sum / static_cast<double>(samples.size() - 3);
  const double z = 1 / fit->plane[0];
  const Eigen::Matrix3d& C = fit->inverse_normal_matrix;
  return PlaneDepth{z, std::hypot(std::sqrt(variance * C(0, 0)) * z * z, options.min_sigma * z),
                    fit->plane.tail<2>(), std::sqrt(variance * std::max(C(1, 1), C(2, 2)))};
}

}  // namespace

std::optional<PlaneDepth> fit_plane_depth(const cv::Mat& depth, const cv::Mat& labels,
                                          const Eigen::Vector2d& pixel, const PlaneDepthOptions& options) {
  if (depth.empty()) return std::nullopt;
  auto samples = samples_about(depth, labels, pixel, std::max(options.half_window_px, options.half_wide_px));
  keep_near_surface(samples, options.max_jump);
  std::vector<Sample> inner;
  for (const auto& s : samples)
    if (s.offset.cwiseAbs().maxCoeff() < options.half_window_px + 1) inner.push_back(s);
  auto narrow = robust_plane(std::move(inner), options.half_window_px, options);
  if (!narrow || options.half_wide_px <= options.half_window_px) return narrow;
  const auto wide = robust_plane(std::move(samples), options.half_wide_px, options);
  if (!wide) return narrow;
  const double difference = std::abs(wide->depth_m - narrow->depth_m);
  if (difference <= options.agreement_sigmas * narrow->sigma_m) return wide;
  narrow->sigma_m = std::hypot(narrow->sigma_m, options.curvature_share * difference);
  return narrow;
}

}  // namespace uniquadric
