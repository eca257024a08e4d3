#include "simulator/noise/pixel_rays.h"

#include <cassert>

namespace uniquadric {

PixelRays::PixelRays(const Camera& of) : camera(of) {
  if (!camera.has_distortion()) return;
  rays.create(camera.height, camera.width, CV_64FC2);
  columns.create(camera.height, camera.width, CV_64FC1);
  for (int v = 0; v < camera.height; ++v)
    for (int u = 0; u < camera.width; ++u) {
      const auto ray = camera.unproject({u, v});
      assert(ray);
      rays.at<cv::Vec2d>(v, u) = {ray->x(), ray->y()};
      columns.at<double>(v, u) = camera.fx * ray->x() + camera.cx;
    }
}

Eigen::Vector2d PixelRays::at(int u, int v) const {
  if (rays.empty()) return {(u - camera.cx) / camera.fx, (v - camera.cy) / camera.fy};
  const cv::Vec2d& ray = rays.at<cv::Vec2d>(v, u);
  return {ray[0], ray[1]};
}

}  // namespace uniquadric
