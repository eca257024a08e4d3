#include "tests/estimator/arc_scenario.h"

#include <ceres/cost_function.h>
#include <ceres/loss_function.h>
#include <ceres/manifold.h>
#include <ceres/problem.h>
#include <ceres/solver.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/random.h"
#include "estimator/factors/conic.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/shape_block.h"
#include "estimator/factors/shape_prior.h"
#include "estimator/factors/tangent.h"
#include "evaluation/iou/ellipsoid_iou.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 525, 525, 319.5, 239.5, {}};
constexpr double kElevation = 0.35;   // rad
constexpr double kFirstTurn = 0.26;   // rad, of the arc's middle less half of 40 degrees
constexpr double kSideSigma = 0.004;  // m
constexpr double kSideTurn = 0.01;    // rad
constexpr double kDistance = 9;       // of the camera, in mean half extents

Eigen::Vector2d direction(double angle) {
  return {std::cos(angle), std::sin(angle)};
}

Pose view_of(const HullBody& body, double turn) {
  const double distance = kDistance * std::cbrt(body.half_extents_m.prod());
  const Eigen::Vector3d back(std::cos(turn) * std::cos(kElevation), std::sin(turn) * std::cos(kElevation),
                             std::sin(kElevation));
  Eigen::Matrix3d R;
  R.col(2) = -back;
  R.col(0) = R.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), distance * back};
}

// Angle of the rectangle of least area about the body's image.
double rectangle_angle(const HullBody& body, const Pose& camera_from_body) {
  constexpr int kSteps = 360;  // of a quarter turn
  const auto width = [&](double angle) {
    return support_px(body, kCamera, camera_from_body, direction(angle)) +
           support_px(body, kCamera, camera_from_body, -direction(angle));
  };
  double best = 0, least = std::numeric_limits<double>::infinity();
  for (int i = 0; i < kSteps; ++i) {
    const double angle = i * std::numbers::pi / 2 / kSteps;
    const double area = width(angle) * width(angle + std::numbers::pi / 2);
    if (area < least) least = area, best = angle;
  }
  return best;
}

Vector6d random_step(RandomStream& random, double sigma_m, double sigma_rad) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = (i < 3 ? sigma_m : sigma_rad) * random.normal();
  return xi;
}

struct Observed {
  Pose world_from_camera, world_from_body;  // the latter drifted
  std::vector<SupportLine> lines;
};

// The world is the object's frame; the short window's body frame is off from it by an unknown offset.
std::vector<Observed> observe(const HullBody& body, const Pose& object_from_body, const ArcOptions& options,
                              int trial) {
  RandomStream noise(11, "lines", static_cast<std::uint64_t>(trial)), walk(11, "drift", trial);
  std::vector<Observed> views;
  Pose drifted = object_from_body;
  for (int i = 0; i < options.views; ++i) {
    Observed view;
    view.world_from_camera = view_of(body, kFirstTurn + options.arc_rad * i / (options.views - 1));
    view.world_from_body = drifted;
    const Pose camera_from_object = view.world_from_camera.inverse();
    const double first = options.directions == 4 ? rectangle_angle(body, camera_from_object) : 0;
    for (int k = 0; k < options.directions; ++k) {
      const Eigen::Vector2d n = direction(first + 2 * std::numbers::pi * k / options.directions);
      view.lines.push_back(
          {n, support_px(body, kCamera, camera_from_object, n) + options.noise_px * noise.normal(), true});
    }
    views.push_back(view);
    drifted = drifted * exp_se3(random_step(walk, options.drift_m, options.drift_rad));
  }
  return views;
}

// The ellipse of a rectangle given by its four sides, 90 degrees apart.
Ellipse ellipse_of(const std::vector<SupportLine>& sides) {
  const double a = (sides[0].offset_px + sides[2].offset_px) / 2,
               b = (sides[1].offset_px + sides[3].offset_px) / 2;
  const double along = (sides[0].offset_px - sides[2].offset_px) / 2;
  const double across = (sides[1].offset_px - sides[3].offset_px) / 2;
  Ellipse e{along * sides[0].normal + across * sides[1].normal, std::max(a, b), std::min(a, b), 0};
  const Eigen::Vector2d& major = a >= b ? sides[0].normal : sides[1].normal;
  e.angle_rad = std::fmod(std::atan2(major.y(), major.x()) + std::numbers::pi, std::numbers::pi);
  return e;
}

std::vector<TangentPlane> seen_sides(const HullBody& body, const Pose& body_from_object,
                                     const ArcOptions& options, int trial) {
  RandomStream random(11, "sides", static_cast<std::uint64_t>(trial));
  std::vector<TangentPlane> sides;
  for (int axis = 0; options.sides && axis < 3; ++axis) {
    Eigen::Vector3d turn(random.normal(), random.normal(), random.normal());
    const Eigen::Vector3d normal =
        exp_so3(kSideTurn * turn) * (body_from_object.rotation * Eigen::Vector3d::Unit(axis));
    const double reach = body.half_extents_m[axis] + kSideSigma * random.normal();
    sides.push_back({normal, -reach - normal.dot(body_from_object.translation), 1});
  }
  return sides;
}

struct State {
  std::vector<PoseBlock> bodies;
  PoseBlock offset;
  AxesBlock axes;
  std::array<double, 3> exponents;
};

State first_guess(const HullBody& body, const Pose& body_from_object, const std::vector<Observed>& views,
                  const ArcOptions& options, int trial) {
  RandomStream random(11, "guess", static_cast<std::uint64_t>(trial));
  const auto unit = [&] {
    return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
  };
  const Eigen::Vector3d shift = 0.15 * std::cbrt(body.half_extents_m.prod()) * unit();
  const Pose off{exp_so3(0.2 * unit()), shift};
  Eigen::Vector3d axes = body.half_extents_m;
  for (double& a : axes) a *= random.uniform(0.7, 1.4);
  const double q = exponent_block(options.exponents == 0 ? 2 : options.first_exponent);
  State state{{}, pose_block(body_from_object * off), axes_block(axes), {q, q, q}};
  for (const Observed& view : views) state.bodies.push_back(pose_block(view.world_from_body));
  return state;
}

void add_view(ceres::Problem& problem, const Observed& view, double* body, State& state,
              const ArcOptions& options) {
  problem.AddParameterBlock(body, 7, pose_manifold().release());
  if (options.hard)
    problem.SetParameterBlockConstant(body);
  else
    problem.AddResidualBlock(pose_prior_factor(view.world_from_body, options.rigid).release(), nullptr, body);
  if (options.conic) {
    const Ellipse observed = ellipse_of(view.lines);
    const ConicOptions conic{ConicResidual::vector, conic_sigma(observed, std::max(options.noise_px, 0.1))};
    problem.AddResidualBlock(conic_factor(kCamera, view.world_from_camera, observed, conic).release(),
                             nullptr, body, state.offset.data(), state.axes.data());
    return;
  }
  const double depth = view.world_from_camera.translation.norm();
  for (const SupportLine& line : view.lines)
    problem.AddResidualBlock(tangent_factor(tangent_plane(kCamera, view.world_from_camera, line, depth),
                                            {std::max(options.exponents, 1), std::max(options.noise_px, 0.1)})
                                 .release(),
                             new ceres::HuberLoss(3), body, state.offset.data(), state.axes.data(),
                             state.exponents.data());
}

// Sides as depth gives them: tangent planes in the body's frame.
void add_sides(ceres::Problem& problem, PoseBlock& identity, State& state,
               const std::vector<TangentPlane>& sides, const ArcOptions& options) {
  for (const TangentPlane& side : sides)
    problem.AddResidualBlock(tangent_factor(side, {std::max(options.exponents, 1), kSideSigma}).release(),
                             nullptr, identity.data(), state.offset.data(), state.axes.data(),
                             state.exponents.data());
  if (problem.HasParameterBlock(identity.data())) problem.SetParameterBlockConstant(identity.data());
}

double solve(State& state, const std::vector<Observed>& views, const std::vector<TangentPlane>& sides,
             const ArcOptions& options) {
  PoseBlock identity = pose_block({});
  ceres::Problem problem;
  problem.AddParameterBlock(state.offset.data(), 7, pose_manifold().release());
  problem.AddParameterBlock(state.axes.data(), 3);
  problem.AddParameterBlock(state.exponents.data(), std::max(options.exponents, 1));
  for (std::size_t i = 0; i < views.size(); ++i)
    add_view(problem, views[i], state.bodies[i].data(), state, options);
  add_sides(problem, identity, state, sides, options);
  if (options.exponents == 0)
    problem.SetParameterBlockConstant(state.exponents.data());
  else
    problem.AddResidualBlock(exponent_prior_factor(options.exponents).release(), nullptr,
                             state.exponents.data());
  const double size = std::cbrt(axes_from_block(state.axes.data()).prod());
  const Eigen::Vector3d sphere = Eigen::Vector3d::Constant(size);
  problem.AddResidualBlock(axis_prior_factor(sphere, 0.5 * sphere, AxisScale::logarithmic).release(), nullptr,
                           state.axes.data());
  problem.AddResidualBlock(pose_prior_factor(pose_from_block(state.offset), PoseSigmas{size, 0.5}).release(),
                           nullptr, state.offset.data());
  ceres::Solver::Options solver;
  solver.linear_solver_type = options.hard ? ceres::DENSE_QR : ceres::DENSE_SCHUR;
  solver.max_num_iterations = 100;
  solver.num_threads = 1;
  solver.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(solver, &problem, &summary);
  return 1e3 * summary.total_time_in_seconds;
}

}  // namespace

HullBody hull_box(const std::string& name, const Eigen::Vector3d& half, double edge_radius_m) {
  HullBody body{name, half, {}};
  const Eigen::Vector3d inner = half - Eigen::Vector3d::Constant(edge_radius_m);
  for (int corner = 0; corner < 8; ++corner) {
    const Eigen::Vector3d sign(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    body.balls.push_back({inner.cwiseProduct(sign), edge_radius_m});
  }
  return body;
}

HullBody hull_ellipsoid(const std::string& name, const Eigen::Vector3d& semi_axes_m) {
  return {name, semi_axes_m, {}};
}

HullBody hull_car() {
  HullBody body{"car", {2.2, 0.9, 0.75}, {}};
  for (const double y : {-1.0, 1.0}) {
    for (const double x : {-2.2, 2.2})
      for (const double z : {-0.75, 0.05}) body.balls.push_back({{x, 0.9 * y, z}, 0});
    for (const double x : {-1.3, 0.7}) body.balls.push_back({{x, 0.75 * y, 0.75}, 0});
  }
  return body;
}

std::vector<HullBody> arc_bodies() {
  return {hull_box("cuboid", {0.3, 0.15, 0.2}), hull_box("cube", {0.2, 0.2, 0.2}),
          hull_ellipsoid("ellipsoid", {0.3, 0.15, 0.2}), hull_box("rounded box", {0.3, 0.2, 0.15}, 0.06),
          hull_car()};
}

double support_px(const HullBody& body, const Camera& camera, const Pose& camera_from_body,
                  const Eigen::Vector2d& normal) {
  const auto ellipse_support = [&](const Pose& pose, const Eigen::Vector3d& axes) {
    const Ellipse e = project(camera, pose, axes).ellipse;
    return normal.dot(e.center) + std::sqrt(normal.dot(ellipse_covariance(e) * normal));
  };
  if (body.balls.empty()) return ellipse_support(camera_from_body, body.half_extents_m);
  double largest = -std::numeric_limits<double>::infinity();
  for (const auto& ball : body.balls) {
    const Eigen::Vector3d center = camera_from_body * ball.center;
    const double reach = ball.radius_m > 0 ? ellipse_support({Eigen::Quaterniond::Identity(), center},
                                                             Eigen::Vector3d::Constant(ball.radius_m))
                                           : normal.dot(*camera.project(center));
    largest = std::max(largest, reach);
  }
  return largest;
}

ArcResult run_arc(const HullBody& body, const ArcOptions& options, int trial) {
  RandomStream random(11, "offset", static_cast<std::uint64_t>(trial));
  const Pose object_from_body = exp_se3(random_step(random, 0.05, 0.5));
  const auto views = observe(body, object_from_body, options, trial);
  State state = first_guess(body, object_from_body.inverse(), views, options, trial);
  ArcResult result;
  result.milliseconds =
      solve(state, views, seen_sides(body, object_from_body.inverse(), options, trial), options);
  const Eigen::Vector3d axes = axes_from_block(state.axes.data());
  const Pose offset = pose_from_block(state.offset);
  for (const PoseBlock& world_from_body : state.bodies)
    result.iou +=
        ellipsoid_iou({pose_from_block(world_from_body) * offset, axes}, {{}, body.half_extents_m}) /
        options.views;
  result.rotation_error_rad = log_so3((object_from_body * offset).rotation).norm();
  result.axis_ratio = axes.cwiseQuotient(body.half_extents_m);
  result.exponents = exponents_from_block(state.exponents.data(), std::max(options.exponents, 1));
  return result;
}

}  // namespace uniquadric
