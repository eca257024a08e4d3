#include "estimator/features/patch_alignment.h"

#include <Eigen/LU>
#include <cmath>
#include <vector>

namespace uniquadric {
namespace {

constexpr int kReach = 16;       // of a stored patch: a window of 11x11 seen at 1.7 times the scale, turned
constexpr double kProbe_px = 3;  // of the warp's finite differences
constexpr double kMinFacing = 0.15;  // cosine between ray and normal: 81 degrees
constexpr double kConverged_px = 5e-3;
constexpr double kMinTexture = 4;  // mean square of a template's gradient, (grey levels / px)^2

// Grey level at a subpixel; negative outside.
double level(const cv::Mat& image, double x, double y) {
  const int u = static_cast<int>(std::floor(x)), v = static_cast<int>(std::floor(y));
  if (u < 0 || v < 0 || u + 1 >= image.cols || v + 1 >= image.rows) return -1;
  const std::uint8_t* top = image.ptr<std::uint8_t>(v) + u;
  const std::uint8_t* bottom = image.ptr<std::uint8_t>(v + 1) + u;
  const double a = x - u, b = y - v;
  return (1 - b) * ((1 - a) * top[0] + a * top[1]) + b * ((1 - a) * bottom[0] + a * bottom[1]);
}

// The anchor's patch as it should look now: a square of side 2 half + 1, without its mean, and its gradients.
struct Template {
  std::vector<double> values;
  std::vector<Eigen::Vector2d> gradients;
  Eigen::Matrix2d inverse_hessian;
  double energy = 0, least_curvature = 0;
};

std::optional<Template> make_template(const PatchAnchor& anchor, const Eigen::Matrix2d& warp, int half) {
  const Eigen::Matrix2d back = warp.inverse();
  const int side = 2 * half + 3;  // one more on each side for the gradients
  std::vector<double> wide(side * side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const Eigen::Vector2d p = anchor.place + back * Eigen::Vector2d(x - half - 1, y - half - 1);
      const double value = level(anchor.patch, p.x(), p.y());
      if (value < 0) return std::nullopt;
      wide[y * side + x] = value;
    }
  Template result;
  const int n = (2 * half + 1) * (2 * half + 1);
  double mean = 0;
  Eigen::Vector2d mean_gradient = Eigen::Vector2d::Zero();
  for (int y = 1; y + 1 < side; ++y)
    for (int x = 1; x + 1 < side; ++x) {
      const double* at = &wide[y * side + x];
      result.values.push_back(at[0]);
      result.gradients.emplace_back((at[1] - at[-1]) / 2, (at[side] - at[-side]) / 2);
      mean += at[0] / n;
      mean_gradient += result.gradients.back() / n;
    }
  Eigen::Matrix2d H = Eigen::Matrix2d::Zero();
  for (int i = 0; i < n; ++i) {
    result.values[i] -= mean;
    result.gradients[i] -= mean_gradient;
    H += result.gradients[i] * result.gradients[i].transpose();
    result.energy += result.values[i] * result.values[i];
  }
  const double least = (H.trace() - std::sqrt(std::pow(H(0, 0) - H(1, 1), 2) + 4 * H(0, 1) * H(0, 1))) / 2;
  if (!(least > kMinTexture * n)) return std::nullopt;
  result.inverse_hessian = H.inverse();
  result.least_curvature = least;
  return result;
}

// The image's window about a pixel without its mean; false where it reaches over the border.
bool window(const cv::Mat& gray, const Eigen::Vector2d& pixel, int half, std::vector<double>& values) {
  const int u = static_cast<int>(std::floor(pixel.x())), v = static_cast<int>(std::floor(pixel.y()));
  if (u < half || v < half || u + half + 1 >= gray.cols || v + half + 1 >= gray.rows) return false;
  const double a = pixel.x() - u, b = pixel.y() - v;  // the same for all of them
  const double w00 = (1 - a) * (1 - b), w01 = a * (1 - b), w10 = (1 - a) * b, w11 = a * b;
  const int side = 2 * half + 1;
  values.resize(side * side);
  double mean = 0;
  for (int y = 0; y < side; ++y) {
    const std::uint8_t* top = gray.ptr<std::uint8_t>(v - half + y) + u - half;
    const std::uint8_t* bottom = gray.ptr<std::uint8_t>(v - half + y + 1) + u - half;
    double* out = &values[y * side];
    for (int x = 0; x < side; ++x) {
      out[x] = w00 * top[x] + w01 * top[x + 1] + w10 * bottom[x] + w11 * bottom[x + 1];
      mean += out[x];
    }
  }
  mean /= static_cast<double>(values.size());
  for (double& value : values) value -= mean;
  return true;
}

}  // namespace

std::optional<PatchAnchor> make_anchor(const cv::Mat& gray, const Eigen::Vector2d& pixel,
                                       const Pose& camera_from_map) {
  const int u = static_cast<int>(std::lround(pixel.x())), v = static_cast<int>(std::lround(pixel.y()));
  const cv::Rect square(u - kReach, v - kReach, 2 * kReach + 1, 2 * kReach + 1);
  if ((square & cv::Rect(0, 0, gray.cols, gray.rows)) != square) return std::nullopt;
  return PatchAnchor{gray(square).clone(), pixel - Eigen::Vector2d(square.x, square.y), pixel,
                     camera_from_map};
}

std::optional<Eigen::Matrix2d> anchor_warp(const PatchAnchor& anchor, const SurfaceElement& surface,
                                           const Camera& lens, const Pose& camera_from_map) {
  const Pose now_from_anchor = camera_from_map * anchor.camera_from_map.inverse();
  const Eigen::Vector3d normal = anchor.camera_from_map.rotation * surface.normal;
  const double offset_m = normal.dot(anchor.camera_from_map * surface.point);
  const Eigen::Vector3d now = camera_from_map * surface.point;
  if (!((camera_from_map.rotation * surface.normal).dot(now.normalized()) < -kMinFacing)) return std::nullopt;
  const auto carried = [&](const Eigen::Vector2d& offset) -> std::optional<Eigen::Vector2d> {
    const auto ray = lens.unproject(anchor.pixel + offset);
    if (!ray || !(normal.dot(ray->normalized()) < -kMinFacing)) return std::nullopt;
    return lens.project(now_from_anchor * Eigen::Vector3d(*ray * (offset_m / normal.dot(*ray))));
  };
  const auto left = carried({-kProbe_px, 0}), right = carried({kProbe_px, 0});
  const auto up = carried({0, -kProbe_px}), down = carried({0, kProbe_px});
  if (!left || !right || !up || !down) return std::nullopt;
  Eigen::Matrix2d warp;
  warp << (*right - *left) / (2 * kProbe_px), (*down - *up) / (2 * kProbe_px);
  return warp.determinant() > 0 ? std::optional(warp) : std::nullopt;
}

std::optional<PatchAlignment> align_patch(const PatchAnchor& anchor, const Eigen::Matrix2d& warp,
                                          const cv::Mat& gray, const Eigen::Vector2d& start,
                                          const PatchAlignmentOptions& options) {
  const auto wanted = make_template(anchor, warp, options.half_window_px);
  if (!wanted) return std::nullopt;
  std::vector<double> values;
  PatchAlignment result{start, 0};
  for (int i = 0; i < options.iterations; ++i) {
    if (!window(gray, result.pixel, options.half_window_px, values)) return std::nullopt;
    double product = 0, energy = 0;
    for (std::size_t k = 0; k < values.size(); ++k) {
      product += values[k] * wanted->values[k];
      energy += values[k] * values[k];
    }
    result.correlation = product / std::sqrt(std::max(energy * wanted->energy, 1e-12));
    const double gain = product / wanted->energy;
    if (!(gain > 0)) return std::nullopt;
    Eigen::Vector2d b = Eigen::Vector2d::Zero();
    for (std::size_t k = 0; k < values.size(); ++k)
      b += wanted->gradients[k] * (values[k] / gain - wanted->values[k]);
    const Eigen::Vector2d step = wanted->inverse_hessian * b;
    result.pixel -= step;
    if (!((result.pixel - start).norm() <= options.max_shift_px)) return std::nullopt;
    if (!(step.norm() < kConverged_px)) continue;
    const double squares =
        std::max(energy / (gain * gain) - wanted->energy, 0.0);  // of the residuals, over gain
    result.sigma_px = std::sqrt(squares / static_cast<double>(values.size() - 4) / wanted->least_curvature);
    return result.correlation >= options.min_correlation ? std::optional(result) : std::nullopt;
  }
  return std::nullopt;
}

}  // namespace uniquadric
