#include "evaluation/iou/whitened_pair.h"

#include <Eigen/SVD>
#include <array>
#include <cassert>

namespace uniquadric {
namespace {

// Rounding of the whitened body's centre and semi-axes. Bodies closer than this differ in IoU by less than
// 1e-12.
constexpr double kSameBody = 4e-14;

// Numbers that order a pair whatever the order of its arguments: volume first.
std::array<double, 11> sort_key(const Ellipsoid& e) {
  const auto& a = e.semi_axes_m;
  const auto& t = e.world_from_object.translation;
  const auto& q = e.world_from_object.rotation;
  return {a.prod(), a.x(), a.y(), a.z(), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()};
}

[[maybe_unused]] bool is_valid(const Ellipsoid& e) {
  return e.semi_axes_m.allFinite() && e.semi_axes_m.minCoeff() > 0 &&
         e.world_from_object.translation.allFinite() && e.world_from_object.rotation.coeffs().allFinite();
}

bool same_numbers(const Ellipsoid& a, const Ellipsoid& b) {
  const auto& p = a.world_from_object;
  const auto& q = b.world_from_object;
  return a.semi_axes_m == b.semi_axes_m && p.translation == q.translation &&
         (p.rotation.coeffs() == q.rotation.coeffs() || p.rotation.coeffs() == -q.rotation.coeffs());
}

}  // namespace

WhitenedPair whiten(const Ellipsoid& a, const Ellipsoid& b) {
  assert(is_valid(a) && is_valid(b));
  const bool swap = sort_key(a) < sort_key(b);
  const Ellipsoid& ball = swap ? b : a;
  const Ellipsoid& other = swap ? a : b;
  const Eigen::Vector3d& radii = ball.semi_axes_m;
  const Eigen::Matrix3d ball_from_world =
      ball.world_from_object.rotation.normalized().toRotationMatrix().transpose();
  const Eigen::Matrix3d ball_from_other =
      ball_from_world * other.world_from_object.rotation.normalized().toRotationMatrix();
  const Eigen::Matrix3d shape =
      radii.cwiseInverse().asDiagonal() * ball_from_other * other.semi_axes_m.asDiagonal();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(shape, Eigen::ComputeFullU);
  const Eigen::Vector3d between =
      ball_from_world * (other.world_from_object.translation - ball.world_from_object.translation);
  WhitenedPair pair;
  pair.center = svd.matrixU().transpose() * between.cwiseQuotient(radii);
  pair.semi_axes = svd.singularValues();
  pair.identical = same_numbers(a, b) || (pair.center.cwiseAbs().maxCoeff() < kSameBody &&
                                          (pair.semi_axes.array() - 1).abs().maxCoeff() < kSameBody);
  return pair;
}

}  // namespace uniquadric
