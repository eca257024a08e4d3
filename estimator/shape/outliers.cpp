#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "estimator/base/point_tree.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {
namespace {

std::vector<double> mean_neighbour_distances(const Eigen::Matrix3Xd& points, int neighbours) {
  const PointTree tree(points);
  std::vector<double> means;
  std::vector<PointTree::Neighbour> places(neighbours + 1);  // the first is the point itself
  for (const auto& p : points.colwise()) {
    double sum = 0;
    for (const auto& near : tree.nearest(p, std::numeric_limits<double>::infinity(), places))
      sum += std::sqrt(static_cast<double>(near.squared_m2));
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
