#include "estimator/images/surface_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

namespace uniquadric {
namespace {

// What is seen at the mean depth about each pixel of a part of the image; 0 where none is measured.
cv::Mat mean_points(const cv::Mat& depth, const Camera& camera, const cv::Rect& part, int reach_px) {
  const cv::Size window(2 * reach_px + 1, 2 * reach_px + 1);
  cv::Mat sums, counts, points = cv::Mat::zeros(part.size(), CV_64FC3);
  cv::boxFilter(depth(part), sums, CV_32F, window, {-1, -1}, false,
                cv::BORDER_ISOLATED | cv::BORDER_REFLECT_101);
  cv::boxFilter((depth(part) > 0) / 255, counts, CV_32F, window, {-1, -1}, false);
  const cv::Mat mean_m = sums / cv::max(counts, 1);
  for (int v = 0; v < part.height; ++v)
    for (int u = 0; u < part.width; ++u) {
      const double z_m = mean_m.at<float>(v, u);
      if (!(z_m > 0)) continue;
      if (const auto ray = camera.unproject({u + part.x, v + part.y}))
        points.at<cv::Vec3d>(v, u) = {z_m * ray->x(), z_m * ray->y(), z_m};
    }
  return points;
}

}  // namespace

cv::Mat surface_normals(const cv::Mat& depth, const Camera& camera, const cv::Rect& region, int reach_px) {
  cv::Mat normals = cv::Mat::zeros(region.size(), CV_64FC3);
  if (std::min(depth.cols, depth.rows) <= 2 * reach_px) return normals;
  const cv::Rect image({0, 0}, depth.size());
  const cv::Point reach(reach_px, reach_px);
  const cv::Rect part = cv::Rect(region.tl() - 2 * reach, region.br() + 2 * reach) & image;
  const cv::Mat points = mean_points(depth, camera, part, reach_px);
  const cv::Rect inside = cv::Rect(reach, image.br() - reach) & region;
  for (int v = inside.y; v < inside.br().y; ++v)
    for (int u = inside.x; u < inside.br().x; ++u) {
      const auto point = [&](int du, int dv) {
        return Eigen::Map<const Eigen::Vector3d>(points.at<cv::Vec3d>(v + dv - part.y, u + du - part.x).val);
      };
      const auto left = point(-reach_px, 0), right = point(reach_px, 0);
      const auto up = point(0, -reach_px), down = point(0, reach_px);
      if (left.isZero() || right.isZero() || up.isZero() || down.isZero()) continue;
      const Eigen::Vector3d normal = (right - left).cross(down - up).normalized();
      normals.at<cv::Vec3d>(v - region.y, u - region.x) = {normal.x(), normal.y(), normal.z()};
    }
  return normals;
}

bool faces_as(const Plane& plane, const cv::Vec3d& normal) {
  const Eigen::Map<const Eigen::Vector3d> own(normal.val);
  return own.isZero() || std::abs(own.dot(plane.normal)) > std::numbers::sqrt2 / 2;
}

}  // namespace uniquadric
