#include "estimator/ego/lidar_observability.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

// The projection onto the main directions that are told.
template <typename IsTold>
Eigen::Matrix3d told_directions(const Eigen::Matrix3d& square, IsTold&& is_told) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(square);
  Eigen::Matrix3d told = Eigen::Matrix3d::Zero();
  for (const auto& v : solver.eigenvectors().colwise())
    if (is_told(v)) told += v * v.transpose();
  return told;
}

}  // namespace

LidarNormal without_feigned(const LidarNormal& normal, const SightingSquare& noise,
                            const std::vector<Eigen::Vector3d>& plane_normals,
                            const ObservabilityOptions& options) {
  const auto stands_out = [&](int part, const Eigen::Vector3d& v) {
    return v.dot(normal.square.block<3, 3>(part, part) * v) >
           options.min_ratio * v.dot(noise.block<3, 3>(part, part) * v);
  };
  const auto is_faced = [&](const Eigen::Vector3d& v) {
    return std::ranges::count_if(plane_normals, [&](const Eigen::Vector3d& n) {
             return std::abs(n.dot(v)) > options.min_cosine;
           }) >= options.min_facing;
  };
  SightingSquare keep = SightingSquare::Zero();
  keep.block<3, 3>(kTurn, kTurn) = keep.block<3, 3>(kGyroscope, kGyroscope) = told_directions(
      normal.square.block<3, 3>(kTurn, kTurn), [&](const auto& v) { return stands_out(kTurn, v); });
  keep.block<3, 3>(kPlace, kPlace) = keep.block<3, 3>(kVelocity, kVelocity) =
      told_directions(normal.square.block<3, 3>(kPlace, kPlace),
                      [&](const auto& v) { return is_faced(v) || stands_out(kPlace, v); });
  return {keep * normal.square * keep, keep * normal.side, normal.points};
}

LidarNormal with_bent_map(const LidarNormal& normal, double velocity_mps, double turn_rate_radps) {
  static_assert(kGyroscope == kVelocity + 3 && kGyroscope + 3 == kSightingDof);
  const Eigen::Matrix<double, kSightingDof, 6> by_bend = normal.square.rightCols<6>();
  Eigen::Matrix<double, 6, 6> bend = by_bend.bottomRows<6>();
  bend.diagonal().head<3>().array() += 1 / (velocity_mps * velocity_mps);
  bend.diagonal().tail<3>().array() += 1 / (turn_rate_radps * turn_rate_radps);
  const Eigen::Matrix<double, kSightingDof, 6> gain = bend.ldlt().solve(by_bend.transpose()).transpose();
  return {normal.square - gain * by_bend.transpose(), normal.side - gain * normal.side.tail<6>(),
          normal.points};
}

}  // namespace uniquadric
