#include "estimator/window/cloud_aligner.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/shape/even_choice.h"
#include "estimator/window/normal_equations.h"

namespace uniquadric {
namespace {

constexpr int kPartners = 6;         // model points among which one with a like normal is looked for
constexpr double kUnmatched = 0.45;  // the cost of a point one sigma off
constexpr double kReach = 1.5;       // of a body that is not known all around, in radii of what is
constexpr double kAgreeing = 0.05;   // radii, by which points end inside the shape that they lie on
constexpr double kConverged = 1e-5;  // [m], [rad]

Eigen::Matrix3Xd joined(const Eigen::Matrix3Xd& a, const Eigen::Matrix3Xd& b) {
  Eigen::Matrix3Xd all(3, a.cols() + b.cols());
  all << a, b;
  return all;
}

double cauchy_loss(double residual) {
  return 2 * std::log1p(residual * residual / 4);
}

}  // namespace

struct CloudAligner::CauchyEquations : NormalEquations {
  double cost = 0;

  void add(const Vector6d& row, double residual) {
    const double weight = 1 / (1 + residual * residual / 4);
    information += weight * row * row.transpose();
    gradient += weight * residual * row;
    cost += kNeighbourEvidence * cauchy_loss(residual);
  }
};

std::vector<CloudPoint> evenly_drawn(const BodyObservation& body, int most) {
  std::vector<CloudPoint> result;
  if (body.normals.cols() == 0) return result;
  for (const auto k : even_choice(body.points.cols(), most)) {
    result.push_back({body.points.col(k), body.normals.col(k)});
    if (body.colors.cols() > 0) result.back().color = body.colors.col(k);
  }
  return result;
}

Vector6d point_row(const Eigen::Vector3d& p, const Eigen::Vector3d& n) {
  Vector6d row;
  row << -n, -p.cross(n);
  return row;
}

Vector6d line_row(const Camera& camera, const SupportLine& line, const Pose& camera_from_body,
                  const Eigen::Vector3d& p) {
  const double u = camera.fx * line.normal.x(), v = camera.fy * line.normal.y(), z = p.z();
  const Eigen::Vector3d by_point(u / z, v / z, -(u * p.x() + v * p.y()) / (z * z));
  const Eigen::Vector3d turned = camera_from_body.rotation.conjugate() * by_point;
  Vector6d row;
  row << turned, (camera_from_body.inverse() * p).cross(turned);
  return row;
}

double way_cost(const Pose& expected, const Pose& pose, const PoseSigmas& sigmas) {
  const double shift = (pose.translation - expected.translation).norm() / sigmas.translation_m;
  const double turn = expected.rotation.angularDistance(pose.rotation) / sigmas.rotation_rad;
  return (shift * shift + turn * turn) / 2;
}

CloudAligner::CloudAligner(const Camera& camera, const BodyObservation& body, const SurfaceModel& model,
                           const Pose& predicted, const PoseSigmas& sigmas,
                           const CloudAlignmentOptions& options)
    : camera_(camera),
      model_(model),
      predicted_(predicted),
      sigmas_(sigmas),
      options_(options),
      seen_(evenly_drawn(body, options.max_points)),
      is_colored_(body.colors.cols() > 0 && model.colors.cols() > 0),
      points_(joined(model.points, model.assumed_points)),
      normals_(joined(model.normals, model.assumed_normals)),
      bounds_(points_.rowwise().minCoeff(), points_.rowwise().maxCoeff()),
      tree_(points_) {
  std::copy_if(body.silhouette->support.begin(), body.silhouette->support.end(), std::back_inserter(lines_),
               [](const SupportLine& line) { return line.free; });
}

double CloudAligner::distance_at(const Pose& pose) const {
  CloudFit fit;
  fit.pose = pose;
  CauchyEquations equations;
  add_points(fit, options_.far_m, 1, equations);
  return fit.distance_m;
}

CloudFit CloudAligner::fit_from(const Pose& start, const FitEffort& effort) const {
  CloudFit fit;
  fit.pose = start;
  for (int i = 0; i < effort.iterations; ++i) {
    const double share = static_cast<double>(i) / (effort.iterations - 1);
    const double reach_m =
        options_.far_m * std::pow(options_.near_m / options_.far_m, std::min(1.0, 1.5 * share));
    CauchyEquations equations;
    add_points(fit, reach_m, effort.stride, equations);
    if (!add_outline(fit, equations)) return {};
    fit.information = kNeighbourEvidence * equations.information;
    fit.cost = equations.cost + add_prior(fit.pose, equations);
    const Vector6d step = -equations.information.ldlt().solve(equations.gradient);
    if (!step.allFinite()) return {};
    fit.pose = perturbed(fit.pose, step);
    if (fit.pose.translation.z() < kLeastDepth_m) return {};
    if (2 * i > effort.iterations && step.norm() < kConverged) break;
  }
  return fit;
}

double CloudAligner::surface_disagreement(const Pose& pose) const {
  CloudFit fit;
  fit.pose = pose;
  CauchyEquations equations;
  add_points(fit, options_.near_m, 1, equations);
  if (!add_outline(fit, equations)) return std::numeric_limits<double>::infinity();
  const double missing = (1 - fit.matched) * static_cast<double>(seen_.size());
  return equations.cost +
         kNeighbourEvidence * missing * (cauchy_loss(options_.near_m / options_.point_sigma_m) - kUnmatched);
}

bool CloudAligner::holds_points(const Pose& pose) const {
  const Eigen::Vector3d center = pose * bounds_.center();
  const double reach_m = kReach * bounds_.diagonal().norm() / 2;
  const auto held = std::count_if(seen_.begin(), seen_.end(), [&](const CloudPoint& seen) {
    return (seen.position - center).norm() < reach_m;
  });
  return 2 * held >= std::ssize(seen_);
}

double CloudAligner::color_cost(const Pose& pose, std::size_t stride) const {
  if (!is_colored_) return 0;
  const Pose body_from_camera = pose.inverse();
  double cost = 0;
  for (std::size_t k = 0; k < seen_.size(); k += stride) {
    const CloudPoint& seen = seen_[k];
    const auto partner = partner_of(seen, body_from_camera, options_.near_m);
    const bool colored = partner && *partner < model_.colors.cols();  // none is assumed
    const double off = colored ? (seen.color - model_.colors.col(*partner)).norm() / options_.color_sigma : 1;
    cost += cauchy_loss(off);
  }
  return kNeighbourEvidence * cost;
}

// The model's point that is nearest and faces the same way.
std::optional<int> CloudAligner::partner_of(const CloudPoint& seen, const Pose& body_from_camera,
                                            double reach_m) const {
  const Eigen::Vector3d position = body_from_camera * seen.position,
                        normal = body_from_camera.rotation * seen.normal;
  if (bounds_.squaredExteriorDistance(position) > reach_m * reach_m) return std::nullopt;
  std::array<PointTree::Neighbour, kPartners> places;
  for (const auto& near : tree_.nearest(position, reach_m, places))
    if (normals_.col(near.index).dot(normal) >= options_.min_normal_cosine) return near.index;
  return std::nullopt;
}

void CloudAligner::add_points(CloudFit& fit, double reach_m, std::size_t stride,
                              CauchyEquations& equations) const {
  const Pose body_from_camera = fit.pose.inverse();
  int used = 0, matched = 0;
  double sum = 0;
  for (std::size_t k = 0; k < seen_.size(); k += stride) {
    const CloudPoint& seen = seen_[k];
    ++used;
    const auto partner = partner_of(seen, body_from_camera, reach_m);
    if (!partner) continue;
    const Eigen::Vector3d p = body_from_camera * seen.position, n = normals_.col(*partner);
    const double distance = n.dot(p - points_.col(*partner));
    equations.add(point_row(p, n) / options_.point_sigma_m, distance / options_.point_sigma_m);
    sum += std::abs(distance);
    ++matched;
  }
  // what has no partner costs a little, else fewer would be better; not more, as it may be a new face
  equations.cost += kNeighbourEvidence * kUnmatched * (used - matched);
  fit.matched = used ? matched / static_cast<double>(used) : 0;
  fit.distance_m = matched ? sum / matched : 0;
}

CloudAligner::OutlineEnd CloudAligner::end_of(const SupportLine& line, const Eigen::Vector3d& p) const {
  return {p, line.normal.dot((camera_.matrix() * p).hnormalized()) - line.offset_px};
}

// By the shape where the points agree with it, which end some way inside. What lies further out was not
// seen: the outline may well be its, but it does not pull at what is known.
std::optional<CloudAligner::OutlineEnd> CloudAligner::end_along(const SupportLine& line,
                                                                const Pose& camera_from_body,
                                                                const OutlineEnd& seen) const {
  if (!model_.shape) return seen;
  const Pose camera_from_object = camera_from_body * *model_.body_from_object;
  const Eigen::Vector3d plane(line.normal.x(), line.normal.y(), -line.offset_px);
  const Eigen::Vector3d normal = (camera_.matrix().transpose() * plane).normalized();
  const OutlineEnd end =
      end_of(line, camera_from_object *
                       support_point(*model_.shape, camera_from_object.rotation.conjugate() * normal));
  if (end.position.z() < kLeastDepth_m) return std::nullopt;
  const double radius_px = camera_.fx * std::cbrt(model_.shape->semi_axes_m.prod()) / end.position.z();
  if (std::abs(end.beyond_px - seen.beyond_px) < kAgreeing * radius_px) return end;
  if (seen.beyond_px >= 0 || end.beyond_px < seen.beyond_px) return seen;
  return end.beyond_px > 0 ? std::nullopt : std::optional(end);
}

// Whether all of the body is in front of the camera: else it has no outline.
bool CloudAligner::add_outline(CloudFit& fit, CauchyEquations& equations) const {
  const Eigen::Matrix3Xd in_camera =
      (fit.pose.rotation.toRotationMatrix() * model_.points).colwise() + fit.pose.translation;
  if (in_camera.row(2).minCoeff() < kLeastDepth_m) return false;
  const Eigen::RowVectorXd u =
      camera_.fx * in_camera.row(0).cwiseQuotient(in_camera.row(2)).array() + camera_.cx;
  const Eigen::RowVectorXd v =
      camera_.fy * in_camera.row(1).cwiseQuotient(in_camera.row(2)).array() + camera_.cy;
  double sum = 0, beyond = 0;
  Eigen::RowVectorXd reach_px;
  for (const SupportLine& line : lines_) {
    reach_px = line.normal.x() * u + line.normal.y() * v;  // the search for its place alone would be scalar
    const double furthest_px = reach_px.maxCoeff();
    const auto at = std::find(reach_px.begin(), reach_px.end(), furthest_px) - reach_px.begin();
    const auto end = end_along(line, fit.pose, end_of(line, in_camera.col(at)));
    if (!end) continue;
    equations.add(line_row(camera_, line, fit.pose, end->position) / options_.outline_sigma_px,
                  end->beyond_px / options_.outline_sigma_px);
    sum += std::abs(end->beyond_px);
    beyond += std::max(0.0, end->beyond_px);
  }
  const auto count = static_cast<double>(std::max<std::ptrdiff_t>(1, lines()));
  fit.outline_px = sum / count;
  fit.beyond_px = beyond / count;
  return true;
}

double CloudAligner::add_prior(const Pose& pose, CauchyEquations& equations) const {
  const Eigen::Matrix3d R = pose.rotation.toRotationMatrix();
  const Eigen::Vector3d turn = log_so3(predicted_.rotation.conjugate() * pose.rotation);
  const Eigen::Vector3d shift = R.transpose() * (pose.translation - predicted_.translation);
  const double t = 1 / (sigmas_.translation_m * sigmas_.translation_m),
               r = 1 / (sigmas_.rotation_rad * sigmas_.rotation_rad);
  equations.information.diagonal().head<3>().array() += t;
  equations.information.diagonal().tail<3>().array() += r;
  equations.gradient.head<3>() += t * shift;
  equations.gradient.tail<3>() += r * turn;
  return way_cost(predicted_, pose, sigmas_);
}

}  // namespace uniquadric
