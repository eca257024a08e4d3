#include "evaluation/align/alignment.h"

#include <Eigen/SVD>
#include <cassert>
#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr double kRankTolerance = 1e-12;  // of the largest singular value: rounding of the sums

Eigen::Matrix3Xd positions(const std::vector<Pose>& poses) {
  Eigen::Matrix3Xd points(3, poses.size());
  for (std::size_t i = 0; i < poses.size(); ++i)
    points.col(static_cast<Eigen::Index>(i)) = poses[i].translation;
  return points;
}

// Sums of the centred positions, from which every least-squares fit follows.
struct Moments {
  Eigen::Vector3d reference_mean, estimate_mean;
  Eigen::Matrix3d covariance;  // reference * estimate^T / n
  double estimate_variance;

  Moments(const std::vector<Pose>& reference, const std::vector<Pose>& estimate) {
    if (reference.size() < 3) throw InputError("alignment needs at least 3 pairs of poses");
    Eigen::Matrix3Xd x = positions(estimate), y = positions(reference);
    estimate_mean = x.rowwise().mean();
    reference_mean = y.rowwise().mean();
    x.colwise() -= estimate_mean;
    y.colwise() -= reference_mean;
    const double n = static_cast<double>(x.cols());
    covariance = y * x.transpose() / n;
    estimate_variance = x.squaredNorm() / n;
  }
};

Alignment umeyama(const Moments& m, bool with_scale) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(m.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues();
  if (!(singular[1] > kRankTolerance * singular[0]))
    throw InputError("alignment: the positions lie on a line or in a point, which leaves the rotation open");
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (U.determinant() * V.determinant() < 0) signs.z() = -1;
  Alignment result;
  const Eigen::Matrix3d R = U * signs.asDiagonal() * V.transpose();
  result.reference_from_estimate.rotation = Eigen::Quaterniond(R).normalized();
  if (with_scale) result.scale = singular.dot(signs) / m.estimate_variance;
  result.reference_from_estimate.translation = m.reference_mean - result.scale * (R * m.estimate_mean);
  return result;
}

// Minimises sum |R x + t - y|^2 + lever^2 / 2 |R R_x - R_y|_F^2; |.|_F^2 of a turn by a small angle is twice
// its square.
Alignment fit_poses(const std::vector<Pose>& reference, const std::vector<Pose>& estimate, double lever_m) {
  if (reference.empty()) throw InputError("alignment needs at least one pair of poses");
  Eigen::Matrix3Xd x = positions(estimate), y = positions(reference);
  const Eigen::Vector3d x_mean = x.rowwise().mean(), y_mean = y.rowwise().mean();
  Eigen::Matrix3d agreement = (y.colwise() - y_mean) * (x.colwise() - x_mean).transpose();
  for (std::size_t i = 0; i < reference.size(); ++i)
    agreement +=
        lever_m * lever_m / 2 * (reference[i].rotation * estimate[i].rotation.conjugate()).toRotationMatrix();
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(agreement, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  const Eigen::Vector3d signs(1, 1, U.determinant() * V.determinant() < 0 ? -1 : 1);
  const Eigen::Quaterniond R(Eigen::Matrix3d(U * signs.asDiagonal() * V.transpose()));
  return {1, {R.normalized(), y_mean - R.normalized() * x_mean}};
}

Alignment yaw_and_position(const Moments& m) {
  const double sine = m.covariance(1, 0) - m.covariance(0, 1);
  const double cosine = m.covariance(0, 0) + m.covariance(1, 1);
  if (!(std::hypot(sine, cosine) > kRankTolerance * m.covariance.norm()))
    throw InputError("alignment: the positions lie on a vertical line, which leaves the yaw open");
  Alignment result;
  auto& pose = result.reference_from_estimate;
  pose.rotation = Eigen::AngleAxisd(std::atan2(sine, cosine), Eigen::Vector3d::UnitZ());
  pose.translation = m.reference_mean - pose.rotation * m.estimate_mean;
  return result;
}

constexpr std::pair<AlignmentKind, const char*> kNames[] = {
    {AlignmentKind::none, "none"},  {AlignmentKind::first, "first"}, {AlignmentKind::se3, "se3"},
    {AlignmentKind::sim3, "sim3"},  {AlignmentKind::scale, "scale"}, {AlignmentKind::posyaw, "posyaw"},
    {AlignmentKind::poses, "poses"}};

}  // namespace

const char* to_string(AlignmentKind kind) {
  for (const auto& [known, name] : kNames)
    if (known == kind) return name;
  return "";
}

std::optional<AlignmentKind> parse_alignment_kind(std::string_view text) {
  for (const auto& [kind, name] : kNames)
    if (text == name) return kind;
  return std::nullopt;
}

Pose Alignment::operator*(const Pose& pose) const {
  const auto& [rotation, translation] = reference_from_estimate;
  return {rotation * pose.rotation, scale * (rotation * pose.translation) + translation};
}

Alignment align(AlignmentKind kind, const std::vector<Pose>& reference, const std::vector<Pose>& estimate,
                double lever_m) {
  assert(reference.size() == estimate.size());
  switch (kind) {
    case AlignmentKind::none:
      return {};
    case AlignmentKind::first:
      if (reference.empty()) throw InputError("alignment needs at least one pair of poses");
      return {1, reference.front() * estimate.front().inverse()};
    case AlignmentKind::se3:
      return umeyama(Moments(reference, estimate), false);
    case AlignmentKind::sim3:
      return umeyama(Moments(reference, estimate), true);
    case AlignmentKind::scale:
      return {umeyama(Moments(reference, estimate), true).scale, {}};
    case AlignmentKind::posyaw:
      return yaw_and_position(Moments(reference, estimate));
    case AlignmentKind::poses:
      return fit_poses(reference, estimate, lever_m);
  }
  return {};
}

}  // namespace uniquadric
