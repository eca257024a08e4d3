#include "estimator/shape/reach.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kHalf = 0.2;

// Points of the faces of a cube of half side 0.2 m that a camera sees, in its frame.
Eigen::Matrix3Xd seen_cube(const Pose& body_from_camera, RandomStream& random) {
  std::vector<Eigen::Vector3d> points;
  for (int k = 0; k < 3000; ++k) {
    const int axis = k % 3, sign = k % 2 ? 1 : -1;
    Eigen::Vector3d p(random.uniform(), random.uniform(), random.uniform());
    p = kHalf * (2 * p - Eigen::Vector3d::Ones());
    p[axis] = sign * kHalf;
    if (sign * body_from_camera.translation[axis] < kHalf) continue;
    points.push_back(body_from_camera.inverse() * p);
  }
  Eigen::Matrix3Xd matrix(3, std::ssize(points));
  for (Eigen::Index i = 0; i < matrix.cols(); ++i) matrix.col(i) = points[i];
  return matrix;
}

Pose camera_at(double x, double y, double z) {
  return {exp_so3({0.1 * x, 0.2, -0.3 * y}), {x, y, z}};
}

struct Scene {
  std::vector<Eigen::Matrix3Xd> clouds;
  std::vector<PointView> views;
};

Scene views_from(const std::vector<Pose>& cameras) {
  Scene scene;
  RandomStream random(3, "reach");
  for (const Pose& camera : cameras) scene.clouds.push_back(seen_cube(camera, random));
  for (std::size_t i = 0; i < cameras.size(); ++i)
    scene.views.push_back({cameras[i], &scene.clouds[i], nullptr});
  return scene;
}

TEST(Reach, EndsWhereTheFaceThatIsSeenLies) {
  const Scene scene = views_from({camera_at(1, 0.5, 1.5), camera_at(1.2, -0.5, 1.4), camera_at(0.9, 0, 1.6)});
  for (const int axis : {0, 2}) {
    const auto reach = reach_along(scene.views, Eigen::Vector3d::Unit(axis));
    ASSERT_TRUE(reach);
    EXPECT_NEAR(reach->position_m, kHalf, 2e-3);
    EXPECT_EQ(reach->views, 3);
  }
}

TEST(Reach, OfASideThatNoCameraSeesIsWhatIsSeenOfTheFacesBesideIt) {
  const Scene scene = views_from({camera_at(1, 0.5, 1.5), camera_at(1.2, 0.4, 1.4)});
  const auto below = reach_along(scene.views, -Eigen::Vector3d::UnitZ());
  ASSERT_TRUE(below);
  EXPECT_EQ(below->views, 0);
  EXPECT_NEAR(below->position_m, kHalf, 0.01);  // the lower edges of the side faces
}

TEST(Reach, OneViewWithStrayPointsOrAPartHiddenDoesNotMoveTheEnd) {
  Scene scene = views_from(
      {camera_at(1, 0.5, 1.5), camera_at(1.2, -0.5, 1.4), camera_at(0.9, 0, 1.6), camera_at(1, 0.1, 1.5)});
  for (Eigen::Index i = 0; i < 60; ++i)  // something behind, in the mask of the first
    scene.clouds[0].col(i) = scene.views[0].body_from_camera.inverse() * Eigen::Vector3d(0.6, 0, 0);
  Eigen::Matrix3Xd half = scene.clouds[1].leftCols(10);
  scene.views[1].points = &half;  // the rest hidden
  scene.views[1].cut = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
  const auto reach = reach_along(scene.views, Eigen::Vector3d::UnitX());
  ASSERT_TRUE(reach);
  EXPECT_NEAR(reach->position_m, kHalf, 2e-3);
  EXPECT_GE(reach->views, 2);
}

TEST(Reach, SaysWhenEveryViewIsCutOnThatSide) {
  Scene scene = views_from({camera_at(1, 0.5, 1.5), camera_at(1.2, -0.5, 1.4)});
  const Eigen::Vector3d far_side = -Eigen::Vector3d::UnitX();
  EXPECT_FALSE(reach_along(scene.views, far_side)->is_cut);
  for (PointView& view : scene.views) {
    EXPECT_FALSE(reach_along(scene.views, far_side)->is_cut);  // the other one would have seen more
    view.cut.push_back((view.body_from_camera.rotation.conjugate() * far_side).head<2>().normalized());
  }
  EXPECT_TRUE(reach_along(scene.views, far_side)->is_cut);
  EXPECT_FALSE(reach_along(scene.views, Eigen::Vector3d::UnitZ())->is_cut);
}

// The upper half of a ball, or the upper and a side face of a cube, with noise along the normals.
TEST(Reach, NoiseOfAFaceOrABallDoesNotPushTheEndOut) {
  for (const bool ball : {false, true}) {
    RandomStream random(5, "noisy", ball);
    Eigen::Matrix3Xd points(3, 2000), normals(3, 2000);
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const Eigen::Vector3d somewhere(random.normal(), random.normal(), std::abs(random.normal()));
      const double x = random.uniform(-kHalf, kHalf), y = random.uniform(-kHalf, kHalf);
      const bool side = i % 3 == 0;
      normals.col(i) = ball ? somewhere.normalized() : Eigen::Vector3d(side, 0, !side);
      points.col(i) = kHalf * normals.col(i);
      if (!ball) points.col(i) = side ? Eigen::Vector3d(kHalf, y, x) : Eigen::Vector3d(x, y, kHalf);
      points.col(i) += 0.004 * random.normal() * normals.col(i);
    }
    const Pose camera{Eigen::Quaterniond::Identity(), {0, 0, 2}};
    const Eigen::Matrix3Xd seen = points.colwise() - camera.translation;
    const PointView view{camera, &seen, &normals};
    const auto reach = reach_along({view}, Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(reach);
    EXPECT_NEAR(reach->position_m, kHalf, 2e-3);
    const auto by_points = reach_along({{camera, &seen, nullptr}}, Eigen::Vector3d::UnitZ());
    EXPECT_GT(by_points->position_m, reach->position_m + (ball ? 1e-3 : 5e-3));  // what the surface mends
  }
}

// One line of a LiDAR on the upper face, of which no surface can be laid through: its points count.
TEST(Reach, OfASingleLineOfPointsIsThatOfThePoints) {
  RandomStream random(6, "line");
  for (const double slope : {0.0, 0.4}) {
    Eigen::Matrix3Xd points(3, 400), normals(3, 400);
    for (Eigen::Index i = 0; i < points.cols(); ++i) {
      const bool top = i % 2 == 0;
      const double x = random.uniform(-kHalf, kHalf);
      normals.col(i) = top ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX();
      const double noise = 0.004 * random.normal();
      points.col(i) = top ? Eigen::Vector3d(x, slope * x, kHalf + noise) : Eigen::Vector3d(kHalf, 0, x);
    }
    const Pose camera{Eigen::Quaterniond::Identity(), {0, 0, 2}};
    const Eigen::Matrix3Xd seen = points.colwise() - camera.translation;
    const auto reach = reach_along({{camera, &seen, &normals}}, Eigen::Vector3d::UnitZ());
    const auto by_points = reach_along({{camera, &seen, nullptr}}, Eigen::Vector3d::UnitZ());
    ASSERT_TRUE(reach && by_points);
    EXPECT_EQ(reach->position_m, by_points->position_m) << slope;
  }
}

TEST(Reach, OfNothingIsNothing) {
  EXPECT_FALSE(reach_along({}, Eigen::Vector3d::UnitX()));
}

}  // namespace
}  // namespace uniquadric
