#include "estimator/shape/oriented_box.h"

#include <gtest/gtest.h>

#include "box_scene.h"
#include "core/geometry/box_symmetry.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;  // m
constexpr double kFlush =
    1e-9;  // m and rad: points on the faces define them but for the rounding of many products

double angle_to(const OrientedBox& box, const OrientedBox& truth) {
  const Eigen::Matrix3d P = nearest_box_rotation(box.axes, truth.axes);
  return rotation_angle(truth.axes.transpose() * box.axes * P);
}

Eigen::Vector3d extents_as(const OrientedBox& box, const OrientedBox& truth) {
  return relabel_axes(box, nearest_box_rotation(box.axes, truth.axes)).half_extents_m;
}

TEST(Alg1Inliers, Eq12_DistanceToTheSurfaceInsideAndOutside) {
  const OrientedBox box = generic_box({0.4, 0.2, 0.1});
  struct Case {
    Eigen::Vector3d in_box;
    double distance;
  };
  const std::vector<Case> cases = {
      {{0, 0, 0}, 0.1},               // the centre: the nearest face
      {{0.38, 0, 0}, 0.02},           // inside, near the x face
      {{-0.38, 0.195, 0.05}, 0.005},  // inside, near the y face
      {{0.4, 0.1, -0.03}, 0},         // on a face
      {{0.4, -0.2, 0.1}, 0},          // on a corner
      {{0.5, 0, 0}, 0.1},             // before a face
      {{0.43, 0.24, 0}, 0.05},        // off an edge: 3-4-5
      {{-0.41, 0.22, -0.12}, 0.03},   // off a corner: 1-2-2-3
  };
  for (const auto& [in_box, distance] : cases)
    EXPECT_NEAR(distance_to_surface(box, box.center + box.axes * in_box), distance, kRounding)
        << in_box.transpose();
  EXPECT_EQ(cases.size(), 8u);
}

TEST(Alg1Inliers, Eq12_AsPrintedIsZeroAtOneCornerAlone) {
  const OrientedBox box = generic_box({0.4, 0.2, 0.1});
  const auto at = [&](double x, double y, double z) {
    return distance_to_corner(box, box.center + box.axes * Eigen::Vector3d(x, y, z));
  };
  EXPECT_NEAR(at(0.4, 0.2, 0.1), 0, kRounding);
  EXPECT_NEAR(at(0.4, 0.2, -0.1), 0.2, kRounding);              // another corner
  EXPECT_NEAR(at(0.4, 0, 0), std::hypot(0.2, 0.1), kRounding);  // the middle of a face
}

// A plate seen from above: all boxes flush with it have its points on their surface.
TEST(OrientedBox, TheTightOneIsNotTurnedInASingleFace) {
  const OrientedBox truth = generic_box({0.4, 0.1, 0.01});
  Eigen::Matrix3Xd top(3, 0);
  RandomStream random(3, "plate");
  top.resize(3, 400);
  for (auto p : top.colwise())
    p = truth.center +
        truth.axes * Eigen::Vector3d(0.4 * random.uniform(-1, 1), 0.1 * random.uniform(-1, 1), 0.01);
  const auto box = fit_tight_surface_box(top);
  ASSERT_TRUE(box);
  EXPECT_LT(angle_to(*box, truth), 0.02);
  EXPECT_NEAR(box->half_extents_m.maxCoeff(), 0.4, 0.01);
}

TEST(OrientedBox, EveryFitOfAFullSurfaceIsClose) {
  const OrientedBox truth = generic_box({0.4, 0.2, 0.1});
  RandomStream random(1, "full_surface");
  const Eigen::Matrix3Xd cloud = box_cloud(truth, {.spacing_m = 0.02}, random);
  const double kLocal = 2e-3;  // rad and m: three of the starts are random planes, none may lie on a face
  for (const auto& fit : {fit_minimum_volume_box(cloud), fit_surface_box(cloud)}) {
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT(angle_to(*fit, truth), kLocal);
    EXPECT_LT((fit->center - truth.center).norm(), kLocal);
    EXPECT_LT((extents_as(*fit, truth) - truth.half_extents_m).norm(), kLocal);
    EXPECT_NEAR(fit->axes.determinant(), 1, kRounding);
  }
  const double kSampledCovariance =
      0.05;  // rad: the principal axes of 5600 random points are off by some hundredths
  EXPECT_LT(angle_to(*fit_pca_box(cloud), truth), kSampledCovariance);
}

TEST(OrientedBox, AFitWithThreePointsOnOneFaceIsExact) {
  const OrientedBox truth = generic_box({0.4, 0.2, 0.1});
  RandomStream random(8, "exact");
  const Eigen::Matrix3Xd cloud = box_cloud(truth, {.spacing_m = 0.05}, random);
  Eigen::Matrix3Xd ordered(3,
                           cloud.cols());  // from the large last face backwards: the first triple lies on it
  for (Eigen::Index i = 0; i < cloud.cols(); ++i) ordered.col(i) = cloud.col(cloud.cols() - 1 - i);
  int fits = 0;
  for (const auto& fit : {fit_minimum_volume_box(ordered), fit_surface_box(ordered)}) {
    ASSERT_TRUE(fit.has_value());
    EXPECT_LT(angle_to(*fit, truth), kFlush);
    EXPECT_LT((fit->center - truth.center).norm(), kFlush);
    EXPECT_LT((extents_as(*fit, truth) - truth.half_extents_m).norm(), kFlush);
    ++fits;
  }
  EXPECT_EQ(fits, 2);
}

TEST(OrientedBox, TwoFacesFoolTheVolumeButNotTheSurface) {
  // Faces +x and +y alone: in the plane of both, a right triangle with the legs 0.6 and 0.4.
  const OrientedBox truth = generic_box({0.3, 0.2, 0.25});
  RandomStream random(2, "two_faces");
  Eigen::Matrix3Xd cloud(3, 400);
  for (int n = 0; n < 400; ++n) {
    Eigen::Vector3d q(random.uniform(-0.3, 0.3), 0.2, random.uniform(-0.25, 0.25));
    if (n % 2) q = {0.3, random.uniform(-0.2, 0.2), q.z()};
    cloud.col(n) = truth.center + truth.axes * q;
  }
  const auto fit = fit_surface_box(cloud);
  ASSERT_TRUE(fit.has_value());
  EXPECT_LT(angle_to(*fit, truth), kFlush);
  // Along the hypotenuse the volume is that of the box around both legs, up to the points missing at the
  // corners.
  const double hypotenuse = std::atan2(0.4, 0.6);
  const OrientedBox tilted = box_along(truth.axes * exp_so3({0, 0, -hypotenuse}).toRotationMatrix(), cloud);
  const double kMissingCorners = 0.03;  // relative
  EXPECT_NEAR(tilted.half_extents_m.prod() / fit->half_extents_m.prod(), 1, kMissingCorners);
}

TEST(OrientedBox, FewerThanFourPointsAreNoBox) {
  EXPECT_FALSE(fit_pca_box(Eigen::Matrix3Xd::Random(3, 3)).has_value());
  EXPECT_FALSE(fit_minimum_volume_box(Eigen::Matrix3Xd::Random(3, 3)).has_value());
  EXPECT_FALSE(fit_surface_box(Eigen::Matrix3Xd(3, 0)).has_value());
}

TEST(OrientedBox, FlatAndStraightCloudsHaveAThinBox) {
  Eigen::Matrix3Xd flat = Eigen::Matrix3Xd::Random(3, 50);
  flat.row(2).setZero();
  EXPECT_NEAR(fit_minimum_volume_box(flat)->half_extents_m.minCoeff(), 0, kFlush);
  EXPECT_NEAR(fit_surface_box(flat)->half_extents_m.minCoeff(), 0, kFlush);
  Eigen::Matrix3Xd straight = Eigen::Matrix3Xd::Zero(3, 9);
  for (int i = 0; i < 9; ++i) straight(0, i) = i;
  EXPECT_NEAR(fit_surface_box(straight)->half_extents_m.maxCoeff(), 4, kFlush);
}

}  // namespace
}  // namespace uniquadric
