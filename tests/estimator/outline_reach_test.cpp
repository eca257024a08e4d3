#include "estimator/objects/outline_reach.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/geometry/sphere_direction.h"
#include "estimator/objects/seen_extents.h"

namespace uniquadric {
namespace {

const Camera kCamera{640, 480, 500, 500, 319.5, 239.5};
const Eigen::Vector3d kHalf(2.5, 0.6, 0.5);
constexpr int kDirections = 16;
constexpr double kRight_m = 1e-6;  // of what follows exactly

// A camera beside the box, a little above its middle, which sees its side y = -0.6 and neither end.
Pose camera_pose(double x) {
  Pose body_from_camera;
  body_from_camera.translation = {x, -8, 0.3};
  Eigen::Matrix3d axes;  // columns: x, y, z of the camera
  axes << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  body_from_camera.rotation = Eigen::Quaterniond(axes);
  return body_from_camera;
}

// The tangents of a body that is the hull of these points.
Silhouette silhouette_of(const std::vector<Eigen::Vector3d>& corners, const Pose& body_from_camera) {
  Silhouette silhouette;
  for (int k = 0; k < kDirections; ++k) {
    const double angle = 2 * std::numbers::pi * k / kDirections;
    SupportLine line{{std::cos(angle), std::sin(angle)}, -1e9, true};
    for (const Eigen::Vector3d& corner : corners) {
      const Eigen::Vector3d pixel = kCamera.matrix() * (body_from_camera.inverse() * corner);
      line.offset_px = std::max(line.offset_px, line.normal.dot(Eigen::Vector2d(pixel.hnormalized())));
    }
    silhouette.support.push_back(line);
  }
  silhouette.rot_bbox.semi_major = 150;
  silhouette.rot_bbox.semi_minor = 35;
  return silhouette;
}

std::vector<Eigen::Vector3d> corners_of(const Eigen::Vector3d& half) {
  std::vector<Eigen::Vector3d> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? half.x() : -half.x(), i & 2 ? half.y() : -half.y(),
                         i & 4 ? half.z() : -half.z());
  return corners;
}

Shape shape_of(const Eigen::Vector3d& half) {
  Shape shape;
  shape.semi_axes_m = half;
  shape.variances.setConstant(1e-6);
  return shape;
}

PointView view_of(const std::vector<Eigen::Vector3d>& corners, const Pose& body_from_camera) {
  PointView view;
  view.body_from_camera = body_from_camera;
  view.touches = outline_touches(kCamera, silhouette_of(corners, body_from_camera));
  return view;
}

TEST(OutlineReach, OfABoxIsItsEnd) {
  for (const double x : {-1.5, 0.0, 1.5}) {
    const std::vector<PointView> views = {view_of(corners_of(kHalf), camera_pose(x))};
    for (const int sign : {-1, 1}) {
      for (const int axis : {0, 2}) {
        const auto end = reach_by_outlines(shape_of(kHalf), views, axis, sign);
        ASSERT_TRUE(end) << axis << " " << sign;
        EXPECT_NEAR(*end, kHalf[axis], kRight_m) << axis << " " << sign;
      }
      EXPECT_FALSE(reach_by_outlines(shape_of(kHalf), views, 1, sign));  // along the line of sight
    }
  }
}

// Wheels in the middle of a carriage: an outline seen askew may touch anywhere, so it says less, never more.
TEST(OutlineReach, IsNeverBeyondTheBody) {
  std::vector<Eigen::Vector3d> body = corners_of({2.5, 0.6, 0.3});
  for (const Eigen::Vector3d& wheel : corners_of({1.5, 0.4, 0.5})) body.push_back(wheel);
  for (const double yaw : {-0.5, 0.0, 0.5}) {
    Pose body_from_camera = camera_pose(3 * yaw);
    body_from_camera.rotation = body_from_camera.rotation * Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitY());
    const auto end = reach_by_outlines(shape_of(kHalf), {view_of(body, body_from_camera)}, 2, -1);
    ASSERT_TRUE(end);
    EXPECT_LE(*end, 0.5 + kRight_m);
    EXPECT_GT(*end, yaw == 0 ? 0.47 : 0.3);
  }
}

// Its points end a quarter of a metre before the box does: a LiDAR's are sparse, those at a mask's rim taken
// off.
TEST(OutlineReach, HoldsEndsThatFewPointsShow) {
  ShapeView seen;
  seen.world_from_camera = camera_pose(0);
  seen.silhouette = silhouette_of(corners_of(kHalf), seen.world_from_camera);
  seen.points.resize(3, 400);
  for (int i = 0; i < 400; ++i)
    seen.points.col(i) = seen.world_from_camera.inverse() *
                         Eigen::Vector3d(-2.25 + 4.5 * (i % 40) / 39.0, -0.6, -0.5 + (i / 40) / 9.0);
  PointView view = point_view(kCamera, seen);
  Shape solved = shape_of(kHalf);
  solved.exponents = {1, 1, 1};
  solved.semi_axes_m.x() = 2.6;
  const Shape shape = with_seen_extents(solved, {view, view, view}, 1.2);
  EXPECT_NEAR(shape.semi_axes_m.x(), kHalf.x(), 0.01);
  EXPECT_GT(std::sqrt(shape.variances[0]), 0.01);  // which nobody saw
  view.touches.clear();
  EXPECT_LT(with_seen_extents(solved, {view, view, view}, 1.2).semi_axes_m.x(), kHalf.x() - 0.1);
}

// A carriage whose doors lie 5 cm and whose underframe 35 cm behind its side, seen along its track, all
// without noise: its outlines are those of its box. Taken for exact the points would cost up to 0.2 m.
TEST(SurfaceSigma, LetsOutlinesSayWhereALargeBodyEnds) {
  const Eigen::Vector3d half(9, 1.4, 1.7);
  std::vector<ShapeView> views(8);
  for (int i = 0; i < 8; ++i) {
    views[i].world_from_camera = camera_pose(-14 + 4 * i);
    views[i].world_from_camera.translation.tail<2>() << -20, 1.4;
    views[i].silhouette = silhouette_of(corners_of(half), views[i].world_from_camera);
  }
  DepthEvidence depth;
  depth.surface_points.resize(3, 600);
  for (int i = 0; i < 600; ++i) {
    const double x = -8.7 + 17.4 * (i % 50) / 49.0, z = -1.6 + 3.2 * (i / 50) / 11.0;
    const double behind = ((i / 5) % 2) * 0.05 + (z < -1 ? 0.3 : 0);
    depth.surface_points.col(i) = Eigen::Vector3d(x, -half.y() + behind, z);
  }
  const double radius_m = 4;
  LongWindowOptions options;
  options.surface_sigma_m = surface_sigma_m(options, radius_m);
  const AxisBelief sphere{Eigen::Vector3d::Constant(radius_m), Eigen::Vector3d::Constant(radius_m / 2)};
  Shape shape = shape_of({8.8, 1.8, 1.5});
  shape.exponents = {1.3, 1.3, 1.3};
  for (int solve = 0; solve < 5; ++solve)
    shape = solve_shape(kCamera, views, depth, {sphere}, shape, options).shape;
  EXPECT_LT((shape.semi_axes_m - half).cwiseAbs().maxCoeff(), 0.06);
  EXPECT_LT(shape.body_from_object.translation.cwiseAbs().maxCoeff(), 0.06);
}

TEST(SurfaceSigma, OfASmallBodyIsThatOfItsPoints) {
  EXPECT_EQ(surface_sigma_m({}, 0.3), LongWindowOptions{}.surface_sigma_m);
}

// An upright ellipsoid from 22 degrees above, whose lower tip is beyond its horizon.
struct Egg {
  const Eigen::Vector3d half{0.07, 0.15, 0.24};
  Pose body_from_camera;
  std::vector<Eigen::Vector3d> surface;
  Eigen::Matrix3Xd points, normals;  // camera frame, of what is seen, without a rim of 18 mm below

  Egg() {
    const double above_rad = 22 * std::numbers::pi / 180;
    body_from_camera.translation = 2.7 * Eigen::Vector3d(0, -std::cos(above_rad), std::sin(above_rad));
    const Eigen::Vector3d forward = -body_from_camera.translation.normalized();
    Eigen::Matrix3d axes;
    axes << Eigen::Vector3d::UnitX(), forward.cross(Eigen::Vector3d::UnitX()), forward;
    body_from_camera.rotation = Eigen::Quaterniond(axes);
    const int count = 20000;
    for (int i = 0; i < count; ++i) surface.push_back(half.cwiseProduct(sphere_direction(i, count)));
    points.resize(3, count);
    normals.resize(3, count);
    Eigen::Index seen = 0;
    for (std::size_t i = 0; i < surface.size(); i += 3) {
      const Eigen::Vector3d& p = surface[i];
      const Eigen::Vector3d n = p.cwiseQuotient(half.cwiseAbs2()).normalized();
      if (n.dot(body_from_camera.translation - p) <= 0 || p.z() < -half.z() + 0.018) continue;
      points.col(seen) = body_from_camera.inverse() * p;
      normals.col(seen++) = body_from_camera.rotation.conjugate() * n;
    }
    points.conservativeResize(3, seen);
    normals.conservativeResize(3, seen);
  }

  PointView view() const {
    PointView view = view_of(surface, body_from_camera);
    view.points = &points;
    view.normals = &normals;
    view.rays = points.colwise().normalized();
    return view;
  }
};

// Next to the tip its surface is seen, which the tip does not lie before.
TEST(OutlineReach, OfARoundTipIsBehindTheSurfaceNextToIt) {
  const Egg egg;
  PointView view = egg.view();
  const auto reach = reach_by_outlines(shape_of(egg.half), {view}, 2, -1);
  ASSERT_TRUE(reach);
  EXPECT_LE(*reach, egg.half.z() + kRight_m);
  EXPECT_GT(*reach, egg.half.z() - 0.02);
  view.normals = nullptr;
  EXPECT_LT(*reach_by_outlines(shape_of(egg.half), {view}, 2, -1), egg.half.z() - 0.04);
}

// The furthest points of a tip end before it in the mean: a fit that has it right keeps it.
TEST(SeenExtents, LeaveARoundTipThatIsBeyondTheHorizon) {
  const Egg egg;
  PointView view = egg.view();
  view.touches.clear();
  const Shape shape = with_seen_extents(shape_of(egg.half), {view, view, view}, 0.14);
  EXPECT_NEAR(shape.semi_axes_m.z(), egg.half.z(), 0.004);
  EXPECT_NEAR(shape.body_from_object.translation.z(), 0, 0.004);
}

}  // namespace
}  // namespace uniquadric