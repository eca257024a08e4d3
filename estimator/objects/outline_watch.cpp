#include "estimator/objects/outline_watch.h"

#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr double kRemembered = 1;  // [s], after which the body has turned in ways that nobody knows
constexpr double kJump = 0.25;     // of the largest width: masks that flow carries err by a tenth
constexpr double kPixels = 6;      // and so many, which small bodies are made of

// Distance of opposite tangents at the distance of the body's centre.
std::vector<std::optional<double>> widths(const Silhouette& outline, double m_per_px) {
  const std::size_t half = outline.support.size() / 2;
  std::vector<std::optional<double>> result(half);
  for (std::size_t k = 0; k < half; ++k) {
    const SupportLine &one = outline.support[k], &other = outline.support[k + half];
    if (one.free && other.free) result[k] = m_per_px * (one.offset_px + other.offset_px);
  }
  return result;
}

double metres_per_pixel(const Camera& camera, const Pose& camera_from_body, const Eigen::Vector3d& center) {
  return std::max(0.0, (camera_from_body * center).z()) / camera.fx;
}

}  // namespace

bool OutlineWatch::may_be(const Camera& camera, const Silhouette& outline, std::int64_t stamp_ns,
                          const Pose& camera_from_body, const Eigen::Vector3d& center) const {
  if (!last_ || seconds(last_->stamp_ns, stamp_ns) > kRemembered) return true;
  const double m_per_px = metres_per_pixel(camera, camera_from_body, center);
  const auto now = widths(outline, m_per_px);
  if (now.size() != last_->widths_m.size()) return true;
  double diameter_m = 0;
  for (const auto& width : last_->widths_m) diameter_m = std::max(diameter_m, width.value_or(0));
  const double turned = camera_from_body.rotation.angularDistance(last_->camera_from_body);
  const double most_m = (kJump + turned) * diameter_m + kPixels * m_per_px;
  for (std::size_t k = 0; k < now.size(); ++k)
    if (now[k] && last_->widths_m[k] && std::abs(*now[k] - *last_->widths_m[k]) > most_m) return false;
  return true;
}

void OutlineWatch::trust(const Camera& camera, const Silhouette& outline, std::int64_t stamp_ns,
                         const Pose& camera_from_body, const Eigen::Vector3d& center) {
  last_ = {stamp_ns, camera_from_body.rotation,
           widths(outline, metres_per_pixel(camera, camera_from_body, center))};
}

}  // namespace uniquadric
