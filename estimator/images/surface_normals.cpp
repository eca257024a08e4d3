#include "estimator/images/surface_normals.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "estimator/shape/depth_point.h"

namespace uniquadric {

cv::Mat surface_normals(const cv::Mat& depth, const Camera& camera, const cv::Rect& region, int reach_px) {
  const cv::Size window(2 * reach_px + 1, 2 * reach_px + 1);
  cv::Mat sums, counts, normals = cv::Mat::zeros(depth.size(), CV_64FC3);
  cv::boxFilter(depth, sums, CV_32F, window, {-1, -1}, false);
  cv::boxFilter((depth > 0) / 255, counts, CV_32F, window, {-1, -1}, false);
  const cv::Mat mean_m = sums / cv::max(counts, 1);
  const auto mean = [&](int u, int v) { return depth_point(mean_m, camera, u, v); };
  for (int v = std::max(region.y, reach_px); v < std::min(region.br().y, depth.rows - reach_px); ++v)
    for (int u = std::max(region.x, reach_px); u < std::min(region.br().x, depth.cols - reach_px); ++u) {
      const auto left = mean(u - reach_px, v), right = mean(u + reach_px, v);
      const auto up = mean(u, v - reach_px), down = mean(u, v + reach_px);
      if (!left || !right || !up || !down) continue;
      const Eigen::Vector3d normal = (*right - *left).cross(*down - *up).normalized();
      normals.at<cv::Vec3d>(v, u) = {normal.x(), normal.y(), normal.z()};
    }
  return normals;
}

bool faces_as(const Plane& plane, const cv::Vec3d& normal) {
  const Eigen::Map<const Eigen::Vector3d> own(normal.val);
  return own.isZero() || std::abs(own.dot(plane.normal)) > std::numbers::sqrt2 / 2;
}

}  // namespace uniquadric
