#include "estimator/images/rigid_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

Pose pose_of(const Eigen::Vector3d& rotation_vector, const Eigen::Vector3d& translation) {
  return {exp_so3(rotation_vector), translation};
}

struct Cloud {
  std::vector<PointSighting> sightings;
  Pose camera_from_body;
};

// Points of a body of 0.4 m at 2 m, seen with the noise given.
Cloud make_cloud(int points, double pixel_sigma, double depth_sigma_m, RandomStream& random) {
  const Camera camera;
  Cloud cloud;
  cloud.camera_from_body = pose_of({0.3, -0.5, 0.2}, {0.1, -0.2, 2.1});
  for (int i = 0; i < points; ++i) {
    PointSighting s;
    s.point = 0.2 * Eigen::Vector3d(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    const Eigen::Vector3d p = cloud.camera_from_body * s.point;
    s.pixel = *camera.project(p) + pixel_sigma * Eigen::Vector2d(random.normal(), random.normal());
    s.depth_sigma_m = depth_sigma_m;
    s.depth_m = p.z() + depth_sigma_m * random.normal();
    cloud.sightings.push_back(s);
  }
  return cloud;
}

// At the body's centre, in its frame: one at the camera would carry the rotation's error over 2 m.
Vector6d error_of(const Pose& estimate, const Pose& truth) {
  return log_se3(truth.inverse() * estimate);
}

TEST(RigidMotion, TheResidualsJacobianIsItsDerivative) {
  const Camera camera;
  constexpr double kStep = 1e-6, kTolerance = 1e-4;  // of entries up to 1e4: central differences
  for (const double angle : {0.7, 1e-9, std::numbers::pi - 1e-6}) {
    const Pose pose = pose_of(angle * Eigen::Vector3d(2, -1, 3).normalized(), {0.1, 0.2, 1.8});
    const PointSighting s{{0.1, -0.15, 0.2}, {300, 200}, 1.9, 0.01};
    Eigen::Vector3d r;
    Eigen::Matrix<double, 3, 6> J;
    ASSERT_TRUE(sighting_residual(s, camera, pose, 0.3, &r, &J));
    for (int k = 0; k < 6; ++k) {
      Eigen::Vector3d plus, minus;
      ASSERT_TRUE(
          sighting_residual(s, camera, exp_se3(kStep * Vector6d::Unit(k)) * pose, 0.3, &plus, nullptr));
      ASSERT_TRUE(
          sighting_residual(s, camera, exp_se3(-kStep * Vector6d::Unit(k)) * pose, 0.3, &minus, nullptr));
      EXPECT_LT(((plus - minus) / (2 * kStep) - J.col(k)).norm(), kTolerance * (1 + J.col(k).norm()));
    }
  }
}

TEST(RigidMotion, IsExactWithoutNoise) {
  RandomStream random(1, "test");
  const Cloud cloud = make_cloud(40, 0, 1e-3, random);
  auto exact = cloud.sightings;
  for (auto& s : exact) s.depth_m = (cloud.camera_from_body * s.point).z();
  const auto fit = fit_rigid_motion(exact, Camera(), std::nullopt, {}, random);
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->inliers, 40);
  EXPECT_LT(error_of(fit->camera_from_body, cloud.camera_from_body).norm(), 1e-9);
}

// The error over the covariance that is told is a chi-square of six degrees of freedom.
TEST(RigidMotion, ItsInformationIsHonest) {
  RandomStream random(2, "test");
  RigidMotionOptions options;
  double chi_square = 0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    const Cloud cloud = make_cloud(80, options.pixel_sigma, 0.002, random);
    const auto fit = fit_rigid_motion(cloud.sightings, Camera(), std::nullopt, options, random);
    ASSERT_TRUE(fit);
    EXPECT_LT(error_of(fit->camera_from_body, cloud.camera_from_body).norm(), 0.01);
    const Vector6d e = log_se3(fit->camera_from_body * cloud.camera_from_body.inverse());
    chi_square += e.dot(fit->information * e) / kTrials;
  }
  // Cauchy's weights count each residual for less: the information told is a little too small.
  EXPECT_GT(chi_square, 2.5);
  EXPECT_LT(chi_square, 7);
}

TEST(RigidMotion, RejectsASecondMotion) {
  RandomStream random(3, "test");
  const Camera camera;
  Cloud cloud = make_cloud(100, 0.3, 0.002, random);
  const Pose other = pose_of({0.02, 0.03, 0}, {0.05, 0.03, -0.02}) * cloud.camera_from_body;
  for (int i = 0; i < 40; ++i) {
    const Eigen::Vector3d p = other * cloud.sightings[i].point;
    cloud.sightings[i].pixel = *camera.project(p);
    cloud.sightings[i].depth_m = p.z();
  }
  for (const bool with_prior : {false, true}) {
    const auto fit = fit_rigid_motion(cloud.sightings, camera,
                                      with_prior ? std::optional(other) : std::nullopt, {}, random);
    ASSERT_TRUE(fit);
    for (int i = 0; i < 100; ++i) EXPECT_EQ(fit->inlier[i], i >= 40) << i;
    EXPECT_LT(error_of(fit->camera_from_body, cloud.camera_from_body).norm(), 0.003);
  }
}

TEST(RigidMotion, WorksOnPixelsAloneFromAPrior) {
  RandomStream random(4, "test");
  Cloud cloud = make_cloud(60, 0.1, 0.002, random);
  for (auto& s : cloud.sightings) s.depth_m = 0;
  const Pose prior = pose_of({0.01, 0, -0.01}, {0.005, 0, 0.005}) * cloud.camera_from_body;
  const auto fit = fit_rigid_motion(cloud.sightings, Camera(), prior, {}, random);
  ASSERT_TRUE(fit);
  EXPECT_LT(error_of(fit->camera_from_body, cloud.camera_from_body).norm(), 0.005);
}

TEST(RigidMotion, ClaimsNothingWithoutAConsensus) {
  RandomStream random(5, "test");
  EXPECT_FALSE(fit_rigid_motion({}, Camera(), Pose{}, {}, random));
  const Cloud few = make_cloud(5, 0, 0.001, random);
  EXPECT_FALSE(fit_rigid_motion(few.sightings, Camera(), few.camera_from_body, {}, random));
  Cloud chaos = make_cloud(60, 0, 0.001, random);
  for (auto& s : chaos.sightings) {
    s.pixel = {random.uniform(0, 640), random.uniform(0, 480)};
    s.depth_m = random.uniform(1, 4);
  }
  EXPECT_FALSE(fit_rigid_motion(chaos.sightings, Camera(), std::nullopt, {}, random));
  auto behind = make_cloud(30, 0, 0.001, random).sightings;
  for (auto& s : behind) s.point.z() -= 10, s.depth_m = 0;
  EXPECT_FALSE(fit_rigid_motion(behind, Camera(), pose_of({0, 0, 0}, {0, 0, 2}), {}, random));
  auto one_place = make_cloud(30, 0, 0.001, random).sightings;
  for (auto& s : one_place) s = one_place[0];
  const auto fit = fit_rigid_motion(one_place, Camera(), std::nullopt, {}, random);
  EXPECT_FALSE(fit);  // collinear samples make no hypothesis
}

}  // namespace
}  // namespace uniquadric
