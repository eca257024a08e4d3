#include <pcl/kdtree/kdtree_flann.h>

#include <cmath>
#include <numeric>
#include <vector>

#include "estimator/shape/object_points.h"

namespace uniquadric {
namespace {

std::vector<double> mean_neighbour_distances(const Eigen::Matrix3Xd& points, int neighbours) {
  auto cloud = std::make_shared<pcl::PointCloud<pcl::PointXYZ>>();
  for (const auto& p : points.colwise())
    cloud->emplace_back(p.cast<float>().x(), p.cast<float>().y(), p.cast<float>().z());
  pcl::KdTreeFLANN<pcl::PointXYZ> tree;
  tree.setInputCloud(cloud);
  std::vector<double> means;
  pcl::Indices indices;
  std::vector<float> squared;
  for (const auto& p : *cloud) {
    tree.nearestKSearch(p, neighbours + 1, indices, squared);  // the first is the point itself
    double sum = 0;
    for (const float d2 : squared) sum += std::sqrt(static_cast<double>(d2));
    means.push_back(sum / neighbours);
  }
  return means;
}

}  // namespace

Eigen::Matrix3Xd drop_outliers(const Eigen::Matrix3Xd& points, int neighbours, double sigmas) {
  if (points.cols() <= neighbours) return points;
  const std::vector<double> distances = mean_neighbour_distances(points, neighbours);
  const auto n = static_cast<double>(distances.size());
  const double mean = std::accumulate(distances.begin(), distances.end(), 0.0) / n;
  double squares = 0;
  for (const double d : distances) squares += (d - mean) * (d - mean);
  const double limit = mean + sigmas * std::sqrt(squares / n);
  Eigen::Matrix3Xd kept(3, points.cols());
  Eigen::Index count = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    if (distances[i] <= limit) kept.col(count++) = points.col(i);
  return kept.leftCols(count);
}

}  // namespace uniquadric
