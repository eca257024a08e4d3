#include "evaluation/align/alignment.h"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/SVD>
#include <cassert>
#include <cmath>
#include <string>
#include <utility>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr double kMeanRounding = 1e-12;   // of the mean's size: rounding of its sum
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
  Eigen::Matrix3d covariance;                           // reference * estimate^T / n
  Eigen::Matrix3d reference_scatter, estimate_scatter;  // x * x^T / n
  double estimate_variance;
  std::size_t pairs;

  Moments(const std::vector<Pose>& reference, const std::vector<Pose>& estimate) {
    if (reference.size() < 3) throw InputError("alignment needs at least 3 pairs of poses");
    Eigen::Matrix3Xd x = positions(estimate), y = positions(reference);
    estimate_mean = x.rowwise().mean();
    reference_mean = y.rowwise().mean();
    x.colwise() -= estimate_mean;
    y.colwise() -= reference_mean;
    const double n = static_cast<double>(x.cols());
    covariance = y * x.transpose() / n;
    reference_scatter = y * y.transpose() / n;
    estimate_scatter = x * x.transpose() / n;
    estimate_variance = x.squaredNorm() / n;
    pairs = reference.size();
  }
};

bool is_point(const Eigen::Matrix3d& scatter, const Eigen::Vector3d& mean) {
  return !(scatter.trace() > std::pow(kMeanRounding * mean.norm(), 2));
}

// Where positions lie that leave a turn open; null for others. Of `dimensions` 2 the plane of x and y alone.
const char* narrow_place(const Eigen::Matrix3d& scatter, const Eigen::Vector3d& mean, int dimensions) {
  const Eigen::VectorXd squares = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(
                                      scatter.topLeftCorner(dimensions, dimensions), Eigen::EigenvaluesOnly)
                                      .eigenvalues()
                                      .reverse();
  if (is_point(scatter, mean)) return "in one point";
  if (dimensions == 2) return squares[0] > kRankTolerance * scatter.trace() ? nullptr : "on a vertical line";
  return squares[1] > kRankTolerance * squares[0] ? nullptr : "on a line";
}

// Says which positions leave `what` open.
[[noreturn]] void refuse(AlignmentKind kind, const Moments& m, int dimensions, const std::string& what) {
  const char* const of_reference = narrow_place(m.reference_scatter, m.reference_mean, dimensions);
  const char* const of_estimate = narrow_place(m.estimate_scatter, m.estimate_mean, dimensions);
  const std::string where = of_reference ? of_reference : of_estimate ? of_estimate : "";
  if (where.empty())
    throw OpenAlignment(
        fmt::format("alignment {}: the {} positions of reference and estimate have nothing in "
                    "common that would tell {}",
                    to_string(kind), m.pairs, what),
        false);
  throw OpenAlignment(
      fmt::format("alignment {}: the {} positions{} lie {}, which leaves {} open", to_string(kind), m.pairs,
                  of_reference && of_estimate ? ""
                  : of_reference              ? " of the reference"
                                              : " of the estimate",
                  where, what),
      of_reference != nullptr && of_estimate == nullptr);
}

Alignment umeyama(AlignmentKind kind, const Moments& m) {
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(m.covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Vector3d singular = svd.singularValues();
  if (!(singular[1] > kRankTolerance * singular[0]))
    refuse(kind, m, 3,
           kind == AlignmentKind::scale ? "the rotation of sim3, whose scale this is," : "the rotation");
  const Eigen::Matrix3d U = svd.matrixU(), V = svd.matrixV();
  Eigen::Vector3d signs = Eigen::Vector3d::Ones();
  if (U.determinant() * V.determinant() < 0) signs.z() = -1;
  Alignment result;
  const Eigen::Matrix3d R = U * signs.asDiagonal() * V.transpose();
  result.reference_from_estimate.rotation = Eigen::Quaterniond(R).normalized();
  if (kind != AlignmentKind::se3) result.scale = singular.dot(signs) / m.estimate_variance;
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
  if (is_point(m.reference_scatter, m.reference_mean) || is_point(m.estimate_scatter, m.estimate_mean) ||
      !(std::hypot(sine, cosine) > kRankTolerance * m.covariance.norm()))
    refuse(AlignmentKind::posyaw, m, 2, "the yaw");
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

bool fits_scale(AlignmentKind kind) {
  return kind == AlignmentKind::sim3 || kind == AlignmentKind::scale;
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
    case AlignmentKind::sim3:
      return umeyama(kind, Moments(reference, estimate));
    case AlignmentKind::scale:
      return {umeyama(kind, Moments(reference, estimate)).scale, {}};
    case AlignmentKind::posyaw:
      return yaw_and_position(Moments(reference, estimate));
    case AlignmentKind::poses:
      return fit_poses(reference, estimate, lever_m);
  }
  return {};
}

}  // namespace uniquadric
