#include "estimator/images/plane_depth.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kMostHalf = 10;  // of a window
constexpr int kRounds = 3;     // of fit and rejection
constexpr double kCutVariance =
    1.03;                       // a normal distribution cut at three sigma has lost this of its variance
constexpr int kMinSamples = 8;  // three unknowns and a spread that means something

// Inverse depths of a window, at offsets from its middle pixel; arrays, so that loops over them are quick.
struct Samples {
  static constexpr int kMost = (2 * kMostHalf + 1) * (2 * kMostHalf + 1);
  int count = 0;
  std::array<float, kMost> x, y, w;
  void add(int dx, int dy, float inverse_depth) {
    x[count] = static_cast<float>(dx);
    y[count] = static_cast<float>(dy);
    w[count++] = inverse_depth;
  }
};

struct Middle {
  int u, v, label;
};

int label_at(const cv::Mat& labels, int u, int v) {
  return labels.empty() ? 0 : labels.at<std::uint16_t>(v, u);
}

// Median depth of the pixels beside the middle; 0 when there are few.
float depth_in_the_middle(const cv::Mat& depth, const cv::Mat& labels, const Middle& m) {
  std::array<float, 9> values;
  values.fill(std::numeric_limits<float>::infinity());  // sorted behind all that are known
  int count = 0;
  for (int v = std::max(m.v - 1, 0); v <= std::min(m.v + 1, depth.rows - 1); ++v)
    for (int u = std::max(m.u - 1, 0); u <= std::min(m.u + 1, depth.cols - 1); ++u)
      if (depth.at<float>(v, u) > 0 && label_at(labels, u, v) == m.label)
        values[count++] = depth.at<float>(v, u);
  if (count < 4) return 0;
  std::sort(values.begin(), values.end());
  return values[count / 2];
}

// What lies within a jump of the middle's depth: the surface that the feature is on, when an edge runs
// through the window.
void gather(const cv::Mat& depth, const cv::Mat& labels, const Middle& m, double max_jump, int half_narrow,
            int half, Samples& narrow, Samples& wide) {
  const float z0 = depth_in_the_middle(depth, labels, m);
  const float nearest = z0 / static_cast<float>(1 + max_jump),
              farthest = z0 / static_cast<float>(1 - max_jump);
  if (!(z0 > 0)) return;
  for (int v = std::max(m.v - half, 0); v <= std::min(m.v + half, depth.rows - 1); ++v) {
    const float* row = depth.ptr<float>(v);
    for (int u = std::max(m.u - half, 0); u <= std::min(m.u + half, depth.cols - 1); ++u) {
      const float z = row[u];
      if (z < nearest || z > farthest || label_at(labels, u, v) != m.label) continue;
      wide.add(u - m.u, v - m.v, 1 / z);
      if (std::max(std::abs(u - m.u), std::abs(v - m.v)) <= half_narrow) narrow.add(u - m.u, v - m.v, 1 / z);
    }
  }
}

struct Fit {
  Eigen::Vector3d plane;  // w0, slope
  Eigen::Matrix3d inverse_normal_matrix;
};

std::optional<Fit> least_squares(const Samples& s) {
  // Single precision holds these sums: offsets are whole numbers, depths are known to a thousandth.
  float sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  double sw = 0, sxw = 0, syw = 0;
  for (int i = 0; i < s.count; ++i) {
    sx += s.x[i];
    sy += s.y[i];
    sxx += s.x[i] * s.x[i];
    sxy += s.x[i] * s.y[i];
    syy += s.y[i] * s.y[i];
    sw += s.w[i];
    sxw += static_cast<double>(s.x[i]) * s.w[i];
    syw += static_cast<double>(s.y[i]) * s.w[i];
  }
  Eigen::Matrix3d N;
  N << s.count, sx, sy, sx, sxx, sxy, sy, sxy, syy;
  const Eigen::LDLT<Eigen::Matrix3d> solver(N);
  if (solver.info() != Eigen::Success || !(solver.vectorD().minCoeff() > 1e-3)) return std::nullopt;
  return Fit{solver.solve(Eigen::Vector3d(sw, sxw, syw)), solver.solve(Eigen::Matrix3d::Identity())};
}

void residuals(const Samples& s, const Eigen::Vector3d& plane, std::array<float, Samples::kMost>& r) {
  const float w0 = static_cast<float>(plane[0]), gx = static_cast<float>(plane[1]),
              gy = static_cast<float>(plane[2]);
  for (int i = 0; i < s.count; ++i) r[i] = std::abs(s.w[i] - w0 - gx * s.x[i] - gy * s.y[i]);
}

double mean_square(const std::array<float, Samples::kMost>& r, int count, int unknowns) {
  double sum = 0;
  for (int i = 0; i < count; ++i) sum += static_cast<double>(r[i]) * r[i];
  return sum / std::max(count - unknowns, 1);
}

void keep_below(Samples& s, const std::array<float, Samples::kMost>& r, float limit) {
  int kept = 0;
  for (int i = 0; i < s.count; ++i) {
    s.x[kept] = s.x[i];
    s.y[kept] = s.y[i];
    s.w[kept] = s.w[i];
    kept += r[i] <= limit;
  }
  s.count = kept;
}

struct RobustFit {
  Fit fit;
  double variance;  // of a sample about the plane
};

// The plane of a window's samples in inverse depth, without its outliers.
std::optional<RobustFit> robust_fit(Samples& samples, int half, const PlaneDepthOptions& options) {
  const double side = 2 * half + 1;
  const int needed = std::max(kMinSamples, static_cast<int>(std::lround(options.min_share * side * side)));
  std::array<float, Samples::kMost> r, sorted;
  std::optional<Fit> fit;
  for (int round = 0; round < kRounds; ++round) {
    if (samples.count < needed) return std::nullopt;
    fit = least_squares(samples);
    if (!fit) return std::nullopt;
    residuals(samples, fit->plane, r);
    if (round + 1 == kRounds) break;
    float sigma = static_cast<float>(std::sqrt(mean_square(r, samples.count, 3)));
    if (round == 0) {  // an edge in the window would blow up the mean
      std::copy_n(r.begin(), samples.count, sorted.begin());
      std::nth_element(sorted.begin(), sorted.begin() + samples.count / 2, sorted.begin() + samples.count);
      sigma = static_cast<float>(kMadToSigma) * sorted[samples.count / 2];
    }
    keep_below(samples, r, std::max(static_cast<float>(options.outlier_sigmas) * sigma, 1e-7F));
  }
  return RobustFit{*fit, kCutVariance * mean_square(r, samples.count, 3)};
}

// The same at `offset` from the middle.
std::optional<PlaneDepth> robust_plane(Samples& samples, int half, const Eigen::Vector2d& offset,
                                       const PlaneDepthOptions& options, const WindowNoise& noise) {
  const auto found = robust_fit(samples, half, options);
  if (!found) return std::nullopt;
  const Eigen::Vector3d at(1, offset.x(), offset.y());
  const double inverse_depth = at.dot(found->fit.plane);
  if (!(inverse_depth > 0)) return std::nullopt;
  const double z = 1 / inverse_depth;
  const Eigen::Matrix3d& C = found->fit.inverse_normal_matrix;
  const double middle = found->variance * noise.middle * at.dot(C * at),
               slope = found->variance * noise.slope * std::max(C(1, 1), C(2, 2));
  return PlaneDepth{z, std::hypot(std::sqrt(middle) * z * z, options.min_sigma * z),
                    found->fit.plane.tail<2>(), std::sqrt(slope)};
}

}  // namespace

std::optional<PlaneDepth> fit_plane_depth(const cv::Mat& depth, const cv::Mat& labels,
                                          const Eigen::Vector2d& pixel, const PlaneDepthOptions& options,
                                          const SurfaceNoise& noise) {
  Middle middle{static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())), 0};
  if (depth.empty() || middle.u < 0 || middle.v < 0 || middle.u >= depth.cols || middle.v >= depth.rows)
    return std::nullopt;
  middle.label = label_at(labels, middle.u, middle.v);
  const int half_narrow = std::min(options.half_window_px, kMostHalf);
  const int half_wide = std::min(options.half_wide_px, kMostHalf);
  Samples inner, outer;
  gather(depth, labels, middle, options.max_jump, half_narrow, std::max(half_narrow, half_wide), inner,
         outer);
  const Eigen::Vector2d offset = pixel - Eigen::Vector2d(middle.u, middle.v);
  auto narrow = robust_plane(inner, half_narrow, offset, options, noise.narrow);
  if (!narrow || half_wide <= half_narrow) return narrow;
  const auto wide = robust_plane(outer, half_wide, offset, options, noise.wide);
  if (!wide) return narrow;
  const double difference = std::abs(wide->depth_m - narrow->depth_m);
  if (difference <= options.agreement_sigmas * narrow->sigma_m) return wide;
  narrow->sigma_m = std::hypot(narrow->sigma_m, options.curvature_share * difference);
  return narrow;
}

std::optional<double> residual_ratio(const cv::Mat& depth, const Eigen::Vector2d& pixel,
                                     const PlaneDepthOptions& options) {
  const Middle middle{static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())), 0};
  const int half_narrow = std::min(options.half_window_px, kMostHalf);
  const int half_wide = std::min(options.half_wide_px, kMostHalf);
  if (half_wide <= half_narrow) return std::nullopt;
  Samples inner, outer;
  gather(depth, {}, middle, options.max_jump, half_narrow, half_wide, inner, outer);
  const auto narrow = robust_fit(inner, half_narrow, options);
  const auto wide = robust_fit(outer, half_wide, options);
  if (!narrow || !wide || !(narrow->variance > 0)) return std::nullopt;
  return narrow->variance / wide->variance;
}

}  // namespace uniquadric
