#include "estimator/objects/surface_cloud.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "estimator/shape/even_choice.h"
#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

constexpr std::ptrdiff_t kFewVoxels = 300;
constexpr int kManyViews = 6;  // after which what was met once shows how far apart the points are

}  // namespace

void SurfaceCloud::reset(double radius_m, double reach_m) {
  voxels_.clear();
  views_ = 0;
  is_colored_ = true;
  voxel_m_ = options_.voxel_share * radius_m;
  reach_m_ = 3 * reach_m;
}

SurfaceCloud::Cell SurfaceCloud::cell_of(const Eigen::Vector3d& point) const {
  const Eigen::Vector3d cell = (point / voxel_m_).array().floor();
  return {static_cast<int>(cell.x()), static_cast<int>(cell.y()), static_cast<int>(cell.z())};
}

void SurfaceCloud::add(const BodyObservation& body, const Pose& body_from_camera) {
  ++views_;
  is_colored_ = is_colored_ && body.colors.cols() == body.points.cols();
  for (Eigen::Index i = 0; i < body.points.cols(); ++i) {
    const Eigen::Vector3d p = body_from_camera * body.points.col(i);
    if (p.cwiseAbs().maxCoeff() > reach_m_) continue;
    Voxel& voxel = voxels_[cell_of(p)];
    voxel.sum += p;
    if (body.normals.cols() > 0) voxel.normal += body_from_camera.rotation * body.normals.col(i);
    if (is_colored_) voxel.color += body.colors.col(i);
    ++voxel.hits;
  }
}

// Voxels with enough hits.
bool SurfaceCloud::are_few() const {
  return std::count_if(voxels_.begin(), voxels_.end(), [&](const auto& entry) {
           return entry.second.hits >= options_.min_hits;
         }) < kFewVoxels;
}

int SurfaceCloud::hits_around(const Cell& cell) const {
  int hits = 0;
  for (int i = 0; i < 27; ++i) {
    const auto near = voxels_.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
    if (near != voxels_.end()) hits += near->second.hits;
  }
  return hits;
}

Eigen::Matrix3Xd SurfaceCloud::sample() const {
  const bool few = views_ >= kManyViews && are_few();
  std::vector<Eigen::Vector3d> means;
  for (const auto& [cell, voxel] : voxels_)
    if ((few ? hits_around(cell) : voxel.hits) >= options_.min_hits) means.push_back(voxel.sum / voxel.hits);
  return to_matrix(means)(Eigen::all, even_choice(std::ssize(means), options_.max_points));
}

SurfaceModel SurfaceCloud::model() const {
  const int least = are_few() ? 1 : options_.min_hits;  // of the first view each has one or two
  std::vector<Eigen::Vector3d> points, normals;
  std::vector<Eigen::Vector3f> colors;
  for (const auto& [cell, voxel] : voxels_) {
    if (voxel.hits < least || voxel.normal.isZero()) continue;
    points.push_back(voxel.sum / voxel.hits);
    normals.push_back(voxel.normal.normalized());
    if (is_colored_) colors.push_back(voxel.color / static_cast<float>(voxel.hits));
  }
  return {to_matrix(points), to_matrix(normals), to_matrix(colors)};
}

}  // namespace uniquadric
