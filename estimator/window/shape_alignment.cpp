#include "estimator/window/shape_alignment.h"

#include <ceres/ceres.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/surface_point.h"
#include "estimator/factors/tangent.h"

namespace uniquadric {
namespace {

constexpr double kHuberSigmas = 2;
constexpr double kMinDepth = 0.1;                           // [m]
constexpr double kMaxExponent = 1.98, kMinExponent = 1.02;  // where gauge and support have derivatives
constexpr int kIterations = 20;

struct Fit {
  Pose pose;
  double cost = std::numeric_limits<double>::infinity(), outline_px = 0, surface_m = 0;
};

struct Evidence {
  std::vector<SupportLine> lines;  // free ones
  std::vector<Eigen::Vector3d> points;
};

Evidence evidence_of(const Silhouette& silhouette, const Eigen::Matrix3Xd& points, int most) {
  Evidence evidence;
  std::copy_if(silhouette.support.begin(), silhouette.support.end(), std::back_inserter(evidence.lines),
               [](const SupportLine& line) { return line.free; });
  const Eigen::Index n = std::min<Eigen::Index>(points.cols(), most);
  for (Eigen::Index i = 0; i < n; ++i) evidence.points.push_back(points.col(i * points.cols() / n));
  return evidence;
}

// Mean absolute value of residuals `begin`..`end` of those evaluated.
double mean_absolute(const std::vector<double>& residuals, std::size_t begin, std::size_t end) {
  double sum = 0;
  for (std::size_t i = begin; i < end; ++i) sum += std::abs(residuals[i]);
  return end > begin ? sum / static_cast<double>(end - begin) : 0;
}

Fit fit_from(const Camera& camera, const Evidence& evidence, const Shape& shape, const Pose& start,
             const Pose& predicted, const PoseSigmas& sigmas, const ShapeAlignmentOptions& options) {
  PoseBlock body = pose_block(Pose{}), object = pose_block(start);
  AxesBlock axes = axes_block(shape.semi_axes_m);
  const auto block = [](double q) { return exponent_block(std::clamp(q, kMinExponent, kMaxExponent)); };
  std::array<double, 3> exponents{block(shape.exponents.outline), block(shape.exponents.upper),
                                  block(shape.exponents.lower)};
  ceres::Problem problem;
  problem.AddParameterBlock(object.data(), 7, pose_manifold().release());
  TangentOptions tangent;
  tangent.exponents = 3;
  tangent.sigma_px = options.outline_sigma_px;
  for (const SupportLine& line : evidence.lines)
    problem.AddResidualBlock(
        tangent_factor(tangent_plane(camera, Pose{}, line, start.translation.z()), tangent).release(),
        new ceres::HuberLoss(kHuberSigmas), body.data(), object.data(), axes.data(), exponents.data());
  for (const Eigen::Vector3d& point : evidence.points)
    problem.AddResidualBlock(surface_point_factor(point, options.surface_sigma_m, 3).release(),
                             new ceres::HuberLoss(kHuberSigmas), object.data(), axes.data(),
                             exponents.data());
  problem.AddResidualBlock(pose_prior_factor(predicted, sigmas).release(), nullptr, object.data());
  for (double* constant : {body.data(), axes.data(), exponents.data()})
    if (problem.HasParameterBlock(constant)) problem.SetParameterBlockConstant(constant);
  ceres::Solver::Options solver;
  solver.linear_solver_type = ceres::DENSE_QR;
  solver.max_num_iterations = kIterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  ceres::Problem::EvaluateOptions raw;
  raw.apply_loss_function = false;
  std::vector<double> residuals;
  problem.Evaluate(raw, nullptr, &residuals, nullptr, nullptr);
  const std::size_t lines = evidence.lines.size(), all = lines + evidence.points.size();
  return {pose_from_block(object), summary.final_cost,
          mean_absolute(residuals, 0, lines) * options.outline_sigma_px,
          mean_absolute(residuals, lines, all) * options.surface_sigma_m};
}

}  // namespace

std::optional<Pose> align_to_shape(const Camera& camera, const Silhouette& silhouette,
                                   const Eigen::Matrix3Xd& points, const Shape& shape, const Pose& predicted,
                                   const PoseSigmas& sigmas, bool stale,
                                   const ShapeAlignmentOptions& options) {
  const Evidence evidence = evidence_of(silhouette, points, options.surface_points);
  if (std::ssize(evidence.lines) + std::ssize(evidence.points) < options.min_evidence) return std::nullopt;
  if (predicted.translation.z() < kMinDepth) return std::nullopt;
  std::vector<Pose> starts = {predicted};
  for (int axis = 0; stale && axis < 3; ++axis)
    for (const double turn : {-options.turn_rad, options.turn_rad}) {
      Pose start = predicted;
      start.rotation = start.rotation * exp_so3(turn * Eigen::Vector3d::Unit(axis));
      starts.push_back(start);
    }
  Fit best;
  for (const Pose& start : starts) {
    const Fit fit = fit_from(camera, evidence, shape, start, predicted, sigmas, options);
    if (fit.cost < best.cost) best = fit;
  }
  if (!(best.outline_px < options.max_outline_px && best.surface_m < options.max_surface_m))
    return std::nullopt;
  return best.pose;
}

}  // namespace uniquadric
