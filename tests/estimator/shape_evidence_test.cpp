#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "estimator/objects/beside_outlines.h"
#include "estimator/objects/surface_cloud.h"
#include "estimator/window/long_window.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes(2.1, 0.9, 0.75);  // m
constexpr int kDirections = 16;

Pose world_from_camera_at(double turn_rad) {
  Eigen::Matrix3d R;
  const Eigen::Vector3d back(std::cos(turn_rad) * 0.94, std::sin(turn_rad) * 0.94, 0.34);
  R.col(2) = -back.normalized();
  R.col(0) = R.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), 20 * back.normalized()};
}

// An ellipsoid at the world's origin, 20 m away. Each side of its outline, four tangents, is off by one
// number.
ShapeView view_of(double turn_rad, double noise_px, RandomStream& random) {
  ShapeView view;
  view.world_from_camera = world_from_camera_at(turn_rad);
  const Ellipse e = project(Camera{}, view.world_from_camera.inverse(), kAxes).ellipse;
  double off_px = 0;
  for (int k = 0; k < kDirections; ++k) {
    if (k % 4 == 0) off_px = noise_px * random.normal();
    const double angle = 2 * std::numbers::pi * (k - 1.5) / kDirections;
    const Eigen::Vector2d n(std::cos(angle), std::sin(angle));
    view.silhouette.support.push_back(
        {n, n.dot(e.center) + std::sqrt(n.dot(ellipse_covariance(e) * n)) + off_px, true});
  }
  view.silhouette.segmented = true;
  return view;
}

// Errors in stated sigmas, root mean square over many draws, each axis and place.
TEST(ShapeCovariance, OutlinesThatAreOffByWholeSidesTellNoMoreThanIsStated) {
  constexpr int kTrials = 60;
  Eigen::Matrix<double, 6, 1> squares = Eigen::Matrix<double, 6, 1>::Zero();
  LongWindowOptions options;
  options.exponents = 0;
  options.surface_points = false;
  Shape truth;
  truth.semi_axes_m = kAxes;
  for (int trial = 0; trial < kTrials; ++trial) {
    RandomStream random(5, "sides", static_cast<std::uint64_t>(trial));
    std::vector<ShapeView> views;
    for (int i = 0; i < 8; ++i) views.push_back(view_of(0.3 + 0.15 * i, 1, random));
    const Shape found = solve_shape(Camera{}, views, {}, {{kAxes, kAxes}}, truth, options).shape;
    squares.head<3>() += (found.semi_axes_m - kAxes).cwiseAbs2().cwiseQuotient(found.variances.head<3>());
    squares.tail<3>() +=
        found.body_from_object.translation.cwiseAbs2().cwiseQuotient(found.variances.segment<3>(3));
  }
  const Eigen::Matrix<double, 6, 1> rmse = (squares / kTrials).cwiseSqrt();
  EXPECT_LT(rmse.maxCoeff(), 1.3);  // twice as much where each tangent counts as one of its own
  EXPECT_GT(rmse.maxCoeff(), 0.7);
}

// Whatever sigma was stated: a solve tells by how many pixels its outlines are off.
TEST(ShapeEvidence, OutlinesTellTheirOwnNoise) {
  LongWindowOptions options;
  options.outline_noise = OutlineNoise::measured;
  options.exponents = 0;
  options.surface_points = false;
  Shape truth;
  truth.semi_axes_m = kAxes;
  int cases = 0;
  for (const double noise_px : {0.01, 1.0, 4.0})
    for (const double stated_px : {1.0, 4.0}) {
      RandomStream random(6, "sides");
      std::vector<ShapeView> views;
      for (int i = 0; i < 40; ++i) views.push_back(view_of(0.05 * i, noise_px, random));
      options.outline_sigma_px = stated_px;
      const double found_px = solve_shape(Camera{}, views, {}, {{kAxes, kAxes}}, truth, options).outline_px;
      EXPECT_NEAR(found_px / noise_px, 1, 0.2) << noise_px << " " << stated_px;  // 160 sides: 9 % each
      ++cases;
    }
  EXPECT_EQ(cases, 6);
}

TEST(BesideOutlines, PointsOfTheBackgroundAreDroppedAndThoseOfTheBodyStay) {
  RandomStream random(5, "sides", 0);
  std::vector<ShapeView> views;
  for (int i = 0; i < 4; ++i) views.push_back(view_of(0.3 + 0.1 * i, 1, random));
  Eigen::Matrix3Xd points(3, 5);
  points.col(0) << 2.1, 0, 0;  // its ends
  points.col(1) << 0, 0, 0.75;
  points.col(2) << 0, -1.9, 0;      // 1 m beside it
  points.col(3) << -2.5, -1.2, -1;  // behind it, along the line of sight
  points.col(4) << -8, -3, 0;       // a wall
  const std::vector<bool> beside = beside_outlines(Camera{}, views, points);
  EXPECT_EQ(beside, (std::vector<bool>{false, false, true, false, true}));
  const Pose camera_from_world = views[1].world_from_camera.inverse();
  views[1].points =
      (camera_from_world.rotation.toRotationMatrix() * points).colwise() + camera_from_world.translation;
  views[1].normals = views[1].points;
  drop_beside_outlines(Camera{}, views, points);
  EXPECT_EQ(points.cols(), 3);
  EXPECT_EQ(views[1].points.cols(), 3);
  EXPECT_EQ(views[1].points, views[1].normals);
  for (ShapeView& view : views) view.silhouette.segmented = false;
  points.col(0) << 0, -1.9, 0;
  EXPECT_FALSE(beside_outlines(Camera{}, views, points)[0]);  // of outlines that were carried nothing is said
}

// Voxels of 6 cm; a wall is met thrice in each, a side once in each, a stray is alone.
TEST(SurfaceCloud, WhatALidarMeetsOnceInEachVoxelIsSampledWhileLittleIsKnown) {
  constexpr double kVoxel = 0.06;
  const auto sampled = [&](int wall_rows, int views) {
    SurfaceCloud cloud{{}};
    cloud.reset(1, 2);
    for (int i = 1; i < views; ++i) cloud.add({}, {});
    std::vector<Eigen::Vector3d> points;
    for (int y = 0; y < 20; ++y)
      for (int z = 0; z < wall_rows; ++z)
        points.insert(points.end(), 3, kVoxel * Eigen::Vector3d(0.5, y + 0.5, z + 0.5));
    for (int x = 10; x < 40; ++x) points.push_back(kVoxel * Eigen::Vector3d(x + 0.5, 0.5, 0.5));
    points.push_back(kVoxel * Eigen::Vector3d(30.5, 30.5, 0.5));
    BodyObservation body;
    body.points.resize(3, std::ssize(points));
    for (std::size_t i = 0; i < points.size(); ++i) body.points.col(static_cast<Eigen::Index>(i)) = points[i];
    cloud.add(body, {});
    const Eigen::Matrix3Xd sample = cloud.sample();
    const auto side = (sample.row(0).array() > 5 * kVoxel).count();
    EXPECT_LT((sample.row(1).array()).maxCoeff(), 25 * kVoxel);  // the stray is not among them
    return side;
  };
  EXPECT_EQ(sampled(5, 6), 28);  // but for its ends, which have one neighbour
  EXPECT_EQ(sampled(5, 1), 0);   // of a first view each voxel has one or two
  EXPECT_EQ(sampled(20, 6), 0);
}

}  // namespace
}  // namespace uniquadric
