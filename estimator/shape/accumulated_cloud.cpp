#include "estimator/shape/accumulated_cloud.h"

#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

// 21 bits an axis: bodies up to 2^20 voxels from the frame's origin.
std::uint64_t place_of(const Eigen::Vector3d& p, double voxel_m) {
  std::uint64_t key = 0;
  for (int i = 0; i < 3; ++i) {
    const double cell = std::clamp(std::floor(p[i] / voxel_m), -1048576.0, 1048575.0);
    key = key << 21 | static_cast<std::uint64_t>(static_cast<std::int64_t>(cell) + 1048576);
  }
  return key;
}

}  // namespace

void AccumulatedCloud::add(const Eigen::Matrix3Xd& points, const Pose& body_from_camera) {
  const Eigen::Matrix3d R = body_from_camera.rotation.toRotationMatrix();
  const Eigen::Matrix3d floor = options_.noise_floor_m * options_.noise_floor_m * Eigen::Matrix3d::Identity();
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d sight = options_.noise_per_range * (R * points.col(i));  // as long as its sigma
    insert({1, body_from_camera * Eigen::Vector3d(points.col(i)), sight * sight.transpose() + floor});
  }
  cameras_.push_back(body_from_camera.translation);
}

void AccumulatedCloud::insert(const Voxel& voxel) {
  const auto [entry, is_new] =
      index_.try_emplace(place_of(voxel.sum / voxel.count, voxel_m_), voxels_.size());
  if (is_new) {
    voxels_.push_back(voxel);
    if (static_cast<int>(voxels_.size()) > options_.max_voxels) coarsen();
    return;
  }
  Voxel& here = voxels_[entry->second];
  here.count += voxel.count;
  here.sum += voxel.sum;
  here.noise_sum += voxel.noise_sum;
}

void AccumulatedCloud::coarsen() {
  voxel_m_ *= 2;
  const std::vector<Voxel> before = std::move(voxels_);
  voxels_.clear();
  index_.clear();
  for (const Voxel& voxel : before) insert(voxel);
}

void AccumulatedCloud::transform(const Pose& to_from_body) {
  const Eigen::Matrix3d R = to_from_body.rotation.toRotationMatrix();
  std::vector<Voxel> before = std::move(voxels_);
  voxels_.clear();
  index_.clear();
  for (const Voxel& voxel : before)
    insert({voxel.count, R * voxel.sum + voxel.count * to_from_body.translation,
            R * voxel.noise_sum * R.transpose()});
  for (auto& camera : cameras_) camera = to_from_body * camera;
}

Eigen::Matrix3Xd AccumulatedCloud::points() const {
  Eigen::Matrix3Xd p(3, voxels_.size());
  for (std::size_t i = 0; i < voxels_.size(); ++i) p.col(i) = voxels_[i].sum / voxels_[i].count;
  return p;
}

Eigen::VectorXd AccumulatedCloud::weights() const {
  Eigen::VectorXd w(voxels_.size());
  for (std::size_t i = 0; i < voxels_.size(); ++i) w[i] = voxels_[i].count;
  return w;
}

double AccumulatedCloud::noise_variance(const Eigen::Vector3d& direction) const {
  if (voxels_.empty()) return options_.noise_floor_m * options_.noise_floor_m;
  std::vector<double> place(voxels_.size());
  for (std::size_t i = 0; i < place.size(); ++i) place[i] = direction.dot(voxels_[i].sum) / voxels_[i].count;
  std::vector<double> sorted = place;
  const auto third = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() * 2 / 3);
  std::nth_element(sorted.begin(), third, sorted.end());
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < place.size(); ++i) {
    if (place[i] < *third) continue;
    sum += direction.dot(voxels_[i].noise_sum * direction);
    count += voxels_[i].count;
  }
  return sum / count;
}

}  // namespace uniquadric
