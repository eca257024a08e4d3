#include "estimator/shape/object_points.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "estimator/shape/depth_point.h"
#include "estimator/shape/even_choice.h"
#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

cv::Mat eroded(const cv::Mat& mask, int radius_px) {
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius_px + 1, 2 * radius_px + 1});
  cv::Mat result;
  cv::erode(mask, result, disc, {-1, -1}, 1, cv::BORDER_CONSTANT,
            cv::Scalar(0));  // the image's border cuts too
  return result;
}

bool is_at_edge(const cv::Mat& depth, int u, int v, double ratio) {
  const float z = depth.at<float>(v, u);
  for (const auto& [du, dv] : {std::pair{-1, 0}, {1, 0}, {0, -1}, {0, 1}}) {
    const int x = u + du, y = v + dv;
    if (x < 0 || y < 0 || x >= depth.cols || y >= depth.rows) continue;
    const float other = depth.at<float>(y, x);
    if (other > 0 && std::abs(other - z) > ratio * z) return true;
  }
  return false;
}

std::vector<Eigen::Vector3d> deproject(const cv::Mat& depth, const cv::Mat& mask, const Camera& camera,
                                       const PointOptions& options) {
  std::vector<Eigen::Vector3d> points;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const double z = depth.at<float>(v, u);
      if (mask.at<unsigned char>(v, u) == 0 || !(z > 0 && z < options.max_depth_m)) continue;
      if (is_at_edge(depth, u, v, options.edge_ratio)) continue;
      if (const auto point = depth_point(depth, camera, u, v)) points.push_back(*point);
    }
  return points;
}

Eigen::Matrix3Xd capped(const Eigen::Matrix3Xd& points, Eigen::Index most) {
  return points(Eigen::all, even_choice(points.cols(), most));
}

}  // namespace

Eigen::Matrix3Xd voxel_means(const Eigen::Matrix3Xd& points, double voxel_m) {
  using Cell = std::array<std::int64_t, 3>;
  std::vector<std::pair<Cell, Eigen::Index>> cells;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d cell = (points.col(i) / voxel_m).array().floor();
    cells.push_back({{std::llround(cell.x()), std::llround(cell.y()), std::llround(cell.z())}, i});
  }
  std::sort(cells.begin(), cells.end());
  std::vector<Eigen::Vector3d> means;
  for (std::size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (; end < cells.size() && cells[end].first == cells[begin].first; ++end)
      sum += points.col(cells[end].second);
    means.emplace_back(sum / static_cast<double>(end - begin));
  }
  return to_matrix(means);
}

Eigen::Matrix3Xd object_points(const cv::Mat& depth, const cv::Mat& mask, const Camera& camera,
                               const PointOptions& options) {
  const cv::Mat inner = options.erode_px > 0 ? eroded(mask, options.erode_px) : mask;
  Eigen::Matrix3Xd points = to_matrix(deproject(depth, inner, camera, options));
  points = capped(voxel_means(points, options.voxel_m), options.max_points);
  for (int round = 0; round < options.outlier_rounds; ++round)
    points = drop_outliers(points, options.outlier_neighbours, options.outlier_sigmas);
  return points.cols() < options.min_points ? Eigen::Matrix3Xd(3, 0) : points;
}

}  // namespace uniquadric
