#include "estimator/shape/view_extents.h"

#include <gtest/gtest.h>

#include "core/geometry/box_symmetry.h"
#include "depth_views.h"
#include "estimator/shape/usual_orientation.h"

namespace uniquadric {
namespace {

constexpr double kRangeM = 2.2;

// Cameras all around, their lines of sight spread evenly (a spiral on the sphere).
Pose camera_around(int index, int count) {
  const double z = -1 + (2 * index + 1.0) / count, turn = 2.4 * index, r = std::sqrt(1 - z * z);
  const Eigen::Vector3d back(r * std::cos(turn), r * std::sin(turn), z);
  Eigen::Matrix3d R;
  R.col(2) = -back;
  R.col(0) = R.col(2).unitOrthogonal();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), kRangeM * back};
}

struct Views {
  std::vector<Eigen::Matrix3Xd> clouds;
  std::vector<PointView> views;
};

Views look_at(const RayBody& body, const std::vector<Pose>& cameras) {
  Views result;
  RandomStream random(5, "views");
  const DepthViewOptions noiseless{0, 0, 0};
  for (const Pose& camera : cameras) result.clouds.push_back(depth_view(body, camera, noiseless, random));
  for (std::size_t i = 0; i < cameras.size(); ++i) result.views.push_back({cameras[i], &result.clouds[i]});
  return result;
}

std::vector<Pose> all_around(int count = 25) {
  std::vector<Pose> cameras;
  for (int i = 0; i < count; ++i) cameras.push_back(camera_around(i, count));
  return cameras;
}

std::optional<AxisEstimate> fused(const Views& seen, BodyEnds ends) {
  return fuse_extents(view_extents(seen.views, Eigen::Matrix3d::Identity(), ends), 0.1, ends);
}

Eigen::Vector3d center(const Views& seen, const Eigen::Vector3d& semi_axes_m, BodyEnds ends) {
  return center_of_extents(view_extents(seen.views, Eigen::Matrix3d::Identity(), ends), semi_axes_m);
}

TEST(ViewExtents, Alg2_OfABoxAreItsSemiAxesFromAllAround) {
  const Eigen::Vector3d truth(0.3, 0.2, 0.15);
  const Views seen = look_at(box_body("box", truth), all_around());
  const auto found = fused(seen, BodyEnds::edges);
  ASSERT_TRUE(found);
  EXPECT_LT((found->semi_axes_m - truth).cwiseAbs().maxCoeff(), 0.004);
  EXPECT_LT(center(seen, found->semi_axes_m, BodyEnds::edges).norm(), 0.004);
  EXPECT_LT((found->sigma_m.cwiseQuotient(truth)).maxCoeff(), 0.08);
}

// What a single view has of a ball is its front; Alg. 2 on that gave 0.7 of the radius.
TEST(ViewExtents, Alg2_OfAnEllipsoidAreItsSemiAxesWhateverIsHidden) {
  const Eigen::Vector3d truth(0.22, 0.16, 0.14);
  const Views seen = look_at(ellipsoid_body("egg", truth), all_around());
  const auto round = fused(seen, BodyEnds::round);
  ASSERT_TRUE(round);
  EXPECT_LT((round->semi_axes_m - truth).cwiseQuotient(truth).cwiseAbs().maxCoeff(), 0.09);
  EXPECT_LT(center(seen, round->semi_axes_m, BodyEnds::round).norm(), 0.006);
  const auto edges = fused(seen, BodyEnds::edges);
  EXPECT_LT((edges->semi_axes_m - truth).cwiseQuotient(truth).cwiseAbs().maxCoeff(), 0.08);
}

TEST(ViewExtents, AnAxisAlongTheLineOfSightIsNotKnownAndSaysSo) {
  const double r = 0.2;
  std::vector<Pose> cameras;
  for (int i = 0; i < 10; ++i) cameras.push_back(camera_around(0, 1));
  for (Pose& camera : cameras) {  // all from +z
    Eigen::Matrix3d R;
    R << 1, 0, 0, 0, -1, 0, 0, 0, -1;
    camera = {Eigen::Quaterniond(R), {0, 0, kRangeM}};
  }
  const Views seen = look_at(ellipsoid_body("ball", Eigen::Vector3d::Constant(r)), cameras);
  const auto found = fused(seen, BodyEnds::edges);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->semi_axes_m[2], r / 2, 0.02);  // its front
  EXPECT_GT(found->sigma_m[2], 0.04);
  EXPECT_LT(found->sigma_m.head<2>().maxCoeff(), 0.01);
  EXPECT_LT(center(seen, Eigen::Vector3d::Constant(r), BodyEnds::edges).norm(),
            0.005);  // the foremost point moved inwards by the true axis
}

TEST(ViewExtents, OfABodyInPartHiddenCountOnlyWithoutWholeViews) {
  const Eigen::Vector3d truth(0.3, 0.2, 0.15);
  Views seen = look_at(box_body("box", truth), all_around());
  std::vector<Eigen::Matrix3Xd> halves;
  for (std::size_t i = 0; i < seen.views.size(); i += 2) {
    halves.push_back(seen.clouds[i].leftCols(seen.clouds[i].cols() / 2));
    seen.views[i].cut = {{1, 0}};
  }
  for (std::size_t i = 0; i < halves.size(); ++i) seen.views[2 * i].points = &halves[i];
  const auto found = fused(seen, BodyEnds::edges);
  EXPECT_LT((found->semi_axes_m - truth).cwiseAbs().maxCoeff(), 0.006);
  EXPECT_FALSE(fuse_extents({}, 0.1, BodyEnds::edges));
}

TEST(UsualOrientation, OfBoxesNamedAsTheyComeIsThatOfMostOfThem) {
  RandomStream random(2, "boxes");
  const Eigen::Quaterniond truth = exp_so3({0.4, -0.2, 0.7});
  std::deque<Eigen::Quaterniond> boxes;
  for (int i = 0; i < 30; ++i) {
    const double off = i % 4 == 3 ? 0.5 : 0.02;  // every fourth is another thing's
    const Eigen::Vector3d turn(random.normal(), random.normal(), random.normal());
    const Eigen::Matrix3d& name = box_rotations()[static_cast<std::size_t>(i) % 24];
    boxes.push_back(truth * exp_so3(off * turn) * Eigen::Quaterniond(name));
  }
  const auto usual = usual_orientation(boxes);
  ASSERT_TRUE(usual);
  const UsualOrientation found = updated_orientation(truth * exp_so3({0.1, 0, 0}), 10, *usual);
  EXPECT_LT(found.rotation.angularDistance(truth), 0.02);
  EXPECT_LT(usual->sigma_rad.maxCoeff(), 0.06);
  EXPECT_FALSE(usual_orientation({}));
}

TEST(UsualOrientation, OfABallsBoxesIsNoneAndTurnsNothing) {
  RandomStream random(2, "ball");
  std::deque<Eigen::Quaterniond> boxes;
  for (int i = 0; i < 40; ++i)
    boxes.push_back(
        Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal()).normalized());
  const auto usual = usual_orientation(boxes);
  EXPECT_GT(usual->sigma_rad.minCoeff(), 0.15);
  const Eigen::Quaterniond before = exp_so3({0.1, 0.2, 0.3});
  EXPECT_LT(updated_orientation(before, 0.03, *usual).rotation.angularDistance(before), 0.03);
}

}  // namespace
}  // namespace uniquadric
