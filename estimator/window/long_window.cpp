#include "estimator/window/long_window.h"

#include <ceres/ceres.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>

#include "core/base/quantile.h"
#include "estimator/factors/axis_direction.h"
#include "estimator/factors/conic.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/shape_prior.h"
#include "estimator/factors/surface_point.h"
#include "estimator/factors/tangent.h"

namespace uniquadric {
namespace {

constexpr double kHuberSigmas = 2;
constexpr double kMinDepth = 0.1;       // [m] of a body's centre in a view that counts
constexpr double kFirstExponent = 1.6;  // q where it is to be found: in the middle of its range
// What counts of evidence whose neighbours err together, where covariances are made: a mask is off by whole
// sides, of which four tangents have one; a body is off its model by whole faces.
constexpr double kTangentShare = 0.25, kPointShare = 0.1;

using Shares = std::map<ceres::ResidualBlockId, double>;  // of those below 1

// The blocks that Ceres works on.
struct Blocks {
  std::vector<PoseBlock> bodies;  // world_from_body of each view
  PoseBlock offset;               // body_from_object
  AxesBlock axes;
  std::array<double, 3> exponents;
};

Ellipse upright_ellipse(const std::array<SupportLine, 4>& bbox) {
  const double a = (bbox[0].offset_px + bbox[2].offset_px) / 2,
               b = (bbox[1].offset_px + bbox[3].offset_px) / 2;
  Ellipse ellipse;
  ellipse.center = {(bbox[0].offset_px - bbox[2].offset_px) / 2, (bbox[1].offset_px - bbox[3].offset_px) / 2};
  ellipse.semi_major = std::max(a, b);
  ellipse.semi_minor = std::min(a, b);
  ellipse.angle_rad = a >= b ? 0 : std::numbers::pi / 2;
  return ellipse;
}

std::vector<SupportLine> tangents_of(const Silhouette& silhouette, Outline outline) {
  if (outline == Outline::hull) return silhouette.support;
  const auto sides = outline == Outline::bbox ? silhouette.bbox : sides_of(silhouette);
  return {sides.begin(), sides.end()};
}

void add_tangents(ceres::Problem& problem, const Camera& camera, const ShapeView& view, double* body,
                  Blocks& blocks, const LongWindowOptions& options, Shares& shares) {
  const Pose offset = pose_from_block(blocks.offset);
  const double depth = (view.world_from_camera.inverse() * (view.world_from_body * offset.translation)).z();
  if (depth < kMinDepth) return;
  TangentOptions tangent;
  tangent.exponents = std::max(1, options.exponents);
  tangent.sigma_px = options.outline_sigma_px;
  for (const SupportLine& line : tangents_of(view.silhouette, options.outline)) {
    if (!line.free) continue;
    shares[problem.AddResidualBlock(
        tangent_factor(tangent_plane(camera, view.world_from_camera, line, depth), tangent).release(),
        new ceres::HuberLoss(kHuberSigmas), body, blocks.offset.data(), blocks.axes.data(),
        blocks.exponents.data())] = kTangentShare;
  }
}

// A conic needs the whole outline: views of which a side is cut say nothing.
std::optional<Ellipse> whole_outline(const ShapeView& view, const LongWindowOptions& options) {
  const auto is_free = [](const SupportLine& line) { return line.free; };
  const auto& bbox = view.silhouette.bbox;
  const auto& sides = view.silhouette.side_free;
  const bool upright = options.outline == Outline::bbox;
  if (upright ? !std::all_of(bbox.begin(), bbox.end(), is_free)
              : !std::all_of(sides.begin(), sides.end(), [](bool free) { return free; }))
    return std::nullopt;
  return upright ? upright_ellipse(bbox) : view.silhouette.rot_bbox;
}

void add_conic(ceres::Problem& problem, const Camera& camera, const ShapeView& view, double* body,
               Blocks& blocks, const LongWindowOptions& options) {
  const auto observed = whole_outline(view, options);
  if (!observed) return;
  ConicOptions conic;
  conic.residual =
      options.semantic == SemanticFactor::literal ? ConicResidual::literal : ConicResidual::vector;
  conic.sigma = conic_sigma(*observed, options.outline_sigma_px);
  problem.AddResidualBlock(conic_factor(camera, view.world_from_camera, *observed, conic).release(),
                           new ceres::HuberLoss(kHuberSigmas), body, blocks.offset.data(),
                           blocks.axes.data());
}

void add_view(ceres::Problem& problem, const Camera& camera, const ShapeView& view, double* body,
              Blocks& blocks, const LongWindowOptions& options, Shares& shares) {
  problem.AddParameterBlock(body, 7, pose_manifold().release());
  if (options.rigid_prior == RigidPrior::hard) problem.SetParameterBlockConstant(body);
  if (options.rigid_prior == RigidPrior::soft)
    problem.AddResidualBlock(pose_prior_factor(view.world_from_body, options.rigid_sigmas).release(), nullptr,
                             body);
  if (options.semantic == SemanticFactor::tangent)
    add_tangents(problem, camera, view, body, blocks, options, shares);
  else if (options.semantic != SemanticFactor::none)
    add_conic(problem, camera, view, body, blocks, options);
}

// The plane touches the body, and the axis next to its normal is parallel to that.
void add_contacts(ceres::Problem& problem, const std::vector<ContactSide>& contacts, PoseBlock& still,
                  Blocks& blocks, int exponents) {
  const Eigen::Matrix3d axes = pose_from_block(blocks.offset).rotation.toRotationMatrix();
  for (const ContactSide& contact : contacts) {
    TangentOptions tangent;
    tangent.exponents = exponents;
    problem.AddResidualBlock(
        tangent_factor({contact.direction, -contact.position_m, 1 / contact.sigma_m}, tangent).release(),
        new ceres::CauchyLoss(kHuberSigmas), still.data(), blocks.offset.data(), blocks.axes.data(),
        blocks.exponents.data());
    int axis = 0;
    (axes.transpose() * contact.direction).cwiseAbs().maxCoeff(&axis);
    problem.AddResidualBlock(axis_direction_factor(contact.direction, axis, contact.sigma_rad).release(),
                             nullptr, blocks.offset.data());
  }
}

Blocks make_blocks(const std::vector<ShapeView>& views, const Shape& start,
                   const LongWindowOptions& options) {
  Blocks blocks;
  for (const ShapeView& view : views) blocks.bodies.push_back(pose_block(view.world_from_body));
  blocks.offset = pose_block(start.body_from_object);
  blocks.axes = axes_block(start.semi_axes_m);
  const SuperExponents q = options.held_exponents.value_or(start.exponents);
  const bool fresh = !options.held_exponents && q.outline == 2 && q.upper == 2;
  const auto block = [&](double exponent) {
    return exponent_block(options.exponents == 0 ? 2 : fresh ? kFirstExponent : exponent);
  };
  blocks.exponents = {block(q.outline), block(q.upper), block(q.lower)};
  return blocks;
}

// Variances of axes [m^2], translation and rotation from the inverse of the normal equations of the blocks
// that belong to the body; poses that are free are marginalised with them. Where a solve starts from is no
// evidence: a ball's axes are as well known as its outlines tell. NaN where the normal equations give none.
Vector9d variances_of(ceres::Problem& problem, Blocks& blocks, ceres::ResidualBlockId start,
                      const Shares& shares, const PoseSigmas& offset_sigmas) {
  ceres::Problem::EvaluateOptions evaluate;
  problem.GetResidualBlocks(&evaluate.residual_blocks);
  std::erase(evaluate.residual_blocks, start);
  problem.GetParameterBlocks(&evaluate.parameter_blocks);
  auto& order = evaluate.parameter_blocks;
  std::erase_if(order, [&](double* block) { return problem.IsParameterBlockConstant(block); });
  std::stable_partition(order.begin(), order.end(),
                        [&](double* block) { return block == blocks.axes.data(); });
  std::stable_partition(order.begin(), order.end(),
                        [&](double* block) { return block == blocks.offset.data(); });
  ceres::CRSMatrix crs;
  Vector9d variances = Vector9d::Constant(std::numeric_limits<double>::quiet_NaN());
  if (!problem.Evaluate(evaluate, nullptr, nullptr, nullptr, &crs)) return variances;
  std::vector<double> share_of_row;
  for (const ceres::ResidualBlockId block : evaluate.residual_blocks) {
    const auto share = shares.find(block);
    share_of_row.insert(share_of_row.end(), problem.GetCostFunctionForResidualBlock(block)->num_residuals(),
                        share == shares.end() ? 1 : share->second);
  }
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(crs.num_cols, crs.num_cols);
  for (int row = 0; row < crs.num_rows; ++row)
    for (int i = crs.rows[row]; i < crs.rows[row + 1]; ++i)
      for (int j = crs.rows[row]; j < crs.rows[row + 1]; ++j)
        normal(crs.cols[i], crs.cols[j]) += share_of_row[row] * crs.values[i] * crs.values[j];
  const bool has_offset = !problem.IsParameterBlockConstant(blocks.offset.data());
  const int wanted = has_offset ? 9 : 3;
  if (has_offset) {
    normal.diagonal().head<3>().array() += std::pow(offset_sigmas.translation_m, -2);
    normal.diagonal().segment<3>(3).array() += std::pow(offset_sigmas.rotation_rad, -2);
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  variances.setZero();
  for (int k = 0; k < wanted; ++k) {
    const double variance = solver.solve(Eigen::VectorXd::Unit(crs.num_cols, k))[k];
    const int axis = has_offset ? k - 6 : k;
    if (!(variance >= 0 && std::isfinite(variance)))
      variances[axis >= 0 ? axis : 3 + k] = std::numeric_limits<double>::quiet_NaN();
    else if (axis >= 0)
      variances[axis] = variance * std::exp(2 * blocks.axes[axis]);
    else
      variances[3 + k] = variance;
  }
  return variances;
}

// `still`: the pose of the body's own frame.
void add_depth(ceres::Problem& problem, const DepthEvidence& depth, PoseBlock& still, Blocks& blocks,
               const LongWindowOptions& options, Shares& shares) {
  const int exponents = std::max(1, options.exponents);
  for (Eigen::Index i = 0; options.surface_points && i < depth.surface_points.cols(); ++i)
    shares[problem.AddResidualBlock(
        surface_point_factor(depth.surface_points.col(i), options.surface_sigma_m, exponents).release(),
        new ceres::CauchyLoss(kHuberSigmas), blocks.offset.data(), blocks.axes.data(),
        blocks.exponents.data())] = kPointShare;
  if (options.contacts) add_contacts(problem, depth.contacts, still, blocks, exponents);
  if (problem.HasParameterBlock(still.data())) problem.SetParameterBlockConstant(still.data());
}

// Returns the offset's.
ceres::ResidualBlockId add_priors(ceres::Problem& problem, const std::vector<AxisBelief>& axes,
                                  const Shape& start, Blocks& blocks, const LongWindowOptions& options) {
  for (const AxisBelief& belief : axes)
    problem.AddResidualBlock(
        axis_prior_factor(belief.semi_axes_m, belief.sigma_m, AxisScale::logarithmic).release(), nullptr,
        blocks.axes.data());
  if (options.exponents == 0 || options.held_exponents)
    problem.SetParameterBlockConstant(blocks.exponents.data());
  else
    problem.AddResidualBlock(
        exponent_prior_factor(options.exponents, {.profile_sigma = options.profile_sigma}).release(), nullptr,
        blocks.exponents.data());
  return problem.AddResidualBlock(pose_prior_factor(start.body_from_object, options.offset_sigmas).release(),
                                  nullptr, blocks.offset.data());
}

// How far tangents are off, in their own sigmas: 1.48 medians; 0 where there are none.
double tangent_spread(const ceres::Problem& problem, const Shares& shares) {
  std::vector<double> off;
  for (const auto& [block, share] : shares) {
    double cost = 0, residual = 0;
    if (share == kTangentShare && problem.EvaluateResidualBlock(block, false, &cost, &residual, nullptr))
      off.push_back(std::abs(residual));
  }
  return off.empty() ? 0 : kMadToSigma * upper_median(std::move(off));
}

}  // namespace

std::array<SupportLine, 4> sides_of(const Silhouette& silhouette) {
  const Ellipse& box = silhouette.rot_bbox;
  const Eigen::Vector2d major(std::cos(box.angle_rad), std::sin(box.angle_rad));
  const Eigen::Vector2d minor(-major.y(), major.x());
  std::array<SupportLine, 4> sides;
  const Eigen::Vector2d normals[4] = {major, -major, minor, -minor};
  for (int i = 0; i < 4; ++i)
    sides[i] = {normals[i], normals[i].dot(box.center) + (i < 2 ? box.semi_major : box.semi_minor),
                silhouette.side_free[i]};
  return sides;
}

ShapeSolution solve_shape(const Camera& camera, const std::vector<ShapeView>& views,
                          const DepthEvidence& depth, const std::vector<AxisBelief>& axes, const Shape& start,
                          const LongWindowOptions& options) {
  Blocks blocks = make_blocks(views, start, options);
  ceres::Problem problem;
  const int exponents = std::max(1, options.exponents);
  Shares shares;
  problem.AddParameterBlock(blocks.offset.data(), 7, pose_manifold().release());
  problem.AddParameterBlock(blocks.axes.data(), 3);
  problem.AddParameterBlock(blocks.exponents.data(), exponents);
  for (std::size_t i = 0; i < views.size(); ++i)
    add_view(problem, camera, views[i], blocks.bodies[i].data(), blocks, options, shares);
  PoseBlock still = pose_block(Pose{});
  add_depth(problem, depth, still, blocks, options, shares);
  const auto offset_prior = add_priors(problem, axes, start, blocks, options);
  if (options.rigid_prior == RigidPrior::none)
    problem.SetParameterBlockConstant(blocks.offset.data());  // the poses are free: they carry it
  ceres::Solver::Options solver;
  solver.linear_solver_type = options.rigid_prior == RigidPrior::hard ? ceres::DENSE_QR : ceres::DENSE_SCHUR;
  solver.max_num_iterations = options.max_iterations;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);

  ShapeSolution solution;
  solution.cost = summary.IsSolutionUsable() ? summary.final_cost : std::numeric_limits<double>::infinity();
  solution.shape.body_from_object = pose_from_block(blocks.offset);
  solution.shape.semi_axes_m = axes_from_block(blocks.axes.data());
  solution.shape.exponents = exponents_from_block(blocks.exponents.data(), exponents);
  // what fits worse than its sigmas say is known worse (Birge's ratio)
  const int freedom = summary.num_residuals_reduced - summary.num_effective_parameters_reduced;
  const double misfit = freedom > 0 ? std::max(1.0, 2 * summary.final_cost / freedom) : 1;
  if (options.outline_noise == OutlineNoise::measured)
    solution.outline_px = options.outline_sigma_px * tangent_spread(problem, shares);
  solution.shape.variances =
      misfit * variances_of(problem, blocks, offset_prior, shares, options.covariance_offset_sigmas);
  return solution;
}

std::optional<double> outline_misfit_px(const Camera& camera, const std::vector<ShapeView>& views,
                                        const Shape& shape, const LongWindowOptions& options) {
  const PoseBlock offset = pose_block(shape.body_from_object);
  const AxesBlock axes = axes_block(shape.semi_axes_m);
  double squares = 0;
  int counted = 0;
  for (const ShapeView& view : views) {
    const auto observed = whole_outline(view, options);
    if (!observed) continue;
    ConicOptions conic;
    conic.sigma = conic_sigma(*observed, 1);  // residuals in pixels
    const PoseBlock body = pose_block(view.world_from_body);
    const std::array<const double*, 3> blocks = {body.data(), offset.data(), axes.data()};
    Eigen::Matrix<double, 5, 1> residuals;
    conic_factor(camera, view.world_from_camera, *observed, conic)
        ->Evaluate(blocks.data(), residuals.data(), nullptr);
    squares += residuals.squaredNorm();
    ++counted;
  }
  if (counted == 0) return std::nullopt;
  return std::sqrt(squares);  // the root of n times the mean
}

void thin_views(std::vector<ShapeView>& views, int most) {
  const auto turn = [](const ShapeView& a, const ShapeView& b) {
    const Eigen::Quaterniond p = a.world_from_camera.rotation.conjugate() * a.world_from_body.rotation;
    const Eigen::Quaterniond q = b.world_from_camera.rotation.conjugate() * b.world_from_body.rotation;
    return p.angularDistance(q);
  };
  while (std::ssize(views) > most) {
    std::size_t least = 0;
    double least_turn = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i + 1 < views.size(); ++i)
      for (std::size_t j = i + 1; j < views.size(); ++j)
        if (const double angle = turn(views[i], views[j]); angle < least_turn) {
          least_turn = angle;
          least = i;
        }
    views.erase(views.begin() + static_cast<std::ptrdiff_t>(least));
  }
}

}  // namespace uniquadric
