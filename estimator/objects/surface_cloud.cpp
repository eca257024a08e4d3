#include "estimator/objects/surface_cloud.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace uniquadric {

void SurfaceCloud::reset(double radius_m) {
  voxels_.clear();
  voxel_m_ = options_.voxel_share * radius_m;
  reach_m_ = 3 * radius_m;
}

void SurfaceCloud::add(const Eigen::Matrix3Xd& points) {
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d p = points.col(i);
    if (p.cwiseAbs().maxCoeff() > reach_m_) continue;
    const Eigen::Vector3d cell = (p / voxel_m_).array().floor();
    Voxel& voxel =
        voxels_[{static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())}];
    voxel.sum += p;
    ++voxel.hits;
  }
}

Eigen::Matrix3Xd SurfaceCloud::sample() const {
  std::vector<Eigen::Vector3d> means;
  for (const auto& [cell, voxel] : voxels_)
    if (voxel.hits >= options_.min_hits) means.push_back(voxel.sum / voxel.hits);
  const std::ptrdiff_t n = std::min<std::ptrdiff_t>(std::ssize(means), options_.max_points);
  Eigen::Matrix3Xd points(3, n);
  for (std::ptrdiff_t i = 0; i < n; ++i) points.col(i) = means[i * std::ssize(means) / n];
  return points;
}

}  // namespace uniquadric
