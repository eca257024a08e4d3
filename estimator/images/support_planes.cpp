#include "estimator/images/support_planes.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kIterations =
    400;  // a plane of a fifth of the points is drawn at least once with 0.96, of a third with 1
constexpr int kRounds = 3;

Plane through(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d normal = (b - a).cross(c - a).normalized();
  return {normal, -normal.dot(a)};
}

Plane least_squares(const std::vector<Eigen::Vector3d>& points) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
  for (const auto& p : points) scatter += (p - mean) * (p - mean).transpose();
  const Eigen::Vector3d normal =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(scatter).eigenvectors().col(0);
  return {normal, -normal.dot(mean)};
}

std::vector<Eigen::Vector3d> near_plane(const std::vector<Eigen::Vector3d>& points, const Plane& plane,
                                        double threshold_m) {
  std::vector<Eigen::Vector3d> near;
  std::copy_if(points.begin(), points.end(), std::back_inserter(near),
               [&](const auto& p) { return plane.distance(p) < threshold_m; });
  return near;
}

std::vector<Eigen::Vector3d> largest_plane(const std::vector<Eigen::Vector3d>& points, double threshold_m,
                                           RandomStream& random) {
  std::vector<Eigen::Vector3d> best;
  const auto pick = [&] { return points[random.below(static_cast<std::uint32_t>(points.size()))]; };
  for (int i = 0; i < kIterations; ++i) {
    const Eigen::Vector3d a = pick(), b = pick(), c = pick();
    const Plane plane = through(a, b, c);
    if (!(plane.normal.norm() > 0.5)) continue;  // collinear
    auto near = near_plane(points, plane, threshold_m);
    if (near.size() > best.size()) best = std::move(near);
  }
  return best;
}

double spread_of(const std::vector<Eigen::Vector3d>& points, const Plane& plane) {
  std::vector<double> off;
  for (const Eigen::Vector3d& p : points) off.push_back(plane.distance(p) / std::max(p.z(), 1e-3));
  return kMadToSigma * upper_median(std::move(off));
}

}  // namespace

bool lies_on(const Plane& plane, const Eigen::Vector3d& point, double most_m) {
  constexpr double kSpreads = 4, kLeastSpread = 1e-3;  // the step of an image in millimetres at 1 m
  return plane.distance(point) <
         std::min(most_m, kSpreads * std::max(plane.spread, kLeastSpread) * point.z());
}

std::vector<Plane> find_planes(std::vector<Eigen::Vector3d> points, double threshold_m, double share,
                               int most, RandomStream& random) {
  const double needed = std::max(share * static_cast<double>(points.size()), 3.0);
  std::vector<Plane> planes;
  while (static_cast<int>(planes.size()) < most && static_cast<double>(points.size()) >= needed) {
    auto near = largest_plane(points, threshold_m, random);
    if (static_cast<double>(near.size()) < needed) break;
    // The points about a plane through three of them are cut off along it: those about their own plane count.
    for (int round = 0; round < kRounds; ++round) near = near_plane(points, least_squares(near), threshold_m);
    planes.push_back(least_squares(near));
    planes.back().spread = spread_of(near, planes.back());
    std::erase_if(points, [&](const auto& p) { return planes.back().distance(p) < threshold_m; });
  }
  return planes;
}

}  // namespace uniquadric
