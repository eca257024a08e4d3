#include "simulator/render/box_pixels.h"

#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

constexpr double kMargin_px = 1;  // half a pixel to its edge, and what single precision errs by

struct Span {
  int from = 0, count = 0;
};

// The whole pixels of [0, size) that meet [least - margin, most + margin].
Span clip(double least, double most, int size) {
  const double from = std::clamp(std::floor(least - kMargin_px), 0.0, double(size)),
               to = std::clamp(std::ceil(most + kMargin_px) + 1, 0.0, double(size));
  return {static_cast<int>(from), static_cast<int>(to - from)};
}

}  // namespace

cv::Rect pixels_of_box(const Eigen::AlignedBox3f& box, const Pose& camera_from_object, const Camera& camera,
                       double near_m) {
  if (box.isEmpty()) return {};
  Eigen::AlignedBox2d pixels;
  int near = 0;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Vector3f corner = box.corner(static_cast<Eigen::AlignedBox3f::CornerType>(i));
    const Eigen::Vector3d p = camera_from_object * corner.cast<double>();
    if (p.z() < near_m)
      ++near;
    else
      pixels.extend(
          Eigen::Vector2d(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy));
  }
  if (near == 8) return {};
  if (near > 0) return {0, 0, camera.width, camera.height};
  const Span u = clip(pixels.min().x(), pixels.max().x(), camera.width),
             v = clip(pixels.min().y(), pixels.max().y(), camera.height);
  return {u.from, v.from, u.count, v.count};
}

}  // namespace uniquadric
