#include "estimator/shape/body_carving.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>
#include <vector>

#include "evaluation/iou/mesh_solid.h"
#include "tests/estimator/depth_views.h"

namespace uniquadric {
namespace {

constexpr double kNoise = 0.005, kWall_m = 5, kDistance_m = 1.5;
constexpr int kViews = 40;
const CarvingOptions kOptions{.enabled = true};
const Camera kCamera{320, 240, 262, 262, 159.5, 119.5, {}};

// Evenly over the part of the sphere with z of at least `least_z`.
Pose camera_around(int index, double least_z) {
  const double z = least_z + (1 - least_z) * (index + 0.5) / kViews, ring = std::sqrt(1 - z * z);
  const double angle = index * std::numbers::pi * (3 - std::sqrt(5.0));
  const Eigen::Vector3d back(ring * std::cos(angle), ring * std::sin(angle), z);
  return {Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), -back), kDistance_m * back};
}

// The body before a wall far behind it.
cv::Mat depth_of(const RayBody& body, const Pose& body_from_camera, RandomStream& random) {
  cv::Mat depth(kCamera.height, kCamera.width, CV_32F);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray((u - kCamera.cx) / kCamera.fx, (v - kCamera.cy) / kCamera.fy, 1);
      const double z =
          body.cast(body_from_camera.translation, body_from_camera.rotation * ray).value_or(kWall_m);
      depth.at<float>(v, u) = static_cast<float>(z * (1 + kNoise * random.normal()));
    }
  return depth;
}

std::optional<SurfaceFile> carve(const RayBody& body, const Superellipsoid& start, double least_z = -1,
                                 const SurfaceFile& seen = {}) {
  RandomStream random(1, "carving test");
  BodyCarving carving(start, kNoise, kOptions);
  for (int i = 0; i < kViews; ++i) {
    const Pose pose = camera_around(i, least_z);
    carving.add(depth_of(body, pose, random), kCamera, pose.inverse());
  }
  return carving.carved(seen);
}

// Parts of skateboard_body(): a deck, and four wheels below.
bool is_in_skateboard(const Eigen::Vector3d& p) {
  const auto in = [&](const Eigen::Vector3d& middle, const Eigen::Vector3d& half) {
    return ((p - middle).cwiseAbs().array() <= half.array()).all();
  };
  bool inside = in({0, 0, 0.04}, {0.4, 0.1, 0.01});
  for (const double x : {-0.25, 0.25})
    for (const double y : {-0.07, 0.07}) inside = inside || in({x, y, -0.02}, {0.03, 0.02, 0.03});
  return inside;
}

double iou_with_skateboard(const MeshSolid& solid) {
  std::vector<Eigen::Vector3d> points;
  RandomStream random(2, "carving iou");
  for (int i = 0; i < 100'000; ++i)
    points.emplace_back(random.uniform(-0.42, 0.42), random.uniform(-0.12, 0.12),
                        random.uniform(-0.07, 0.07));
  const std::vector<char> inside = solid.contains(points);
  double common = 0, either = 0;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const bool is_true = is_in_skateboard(points[i]);
    common += inside[i] && is_true;
    either += inside[i] || is_true;
  }
  return common / either;
}

const Superellipsoid kSkateboardBox{{0.4, 0.1, 0.05}, kBoxExponents};

TEST(BodyCarving, TakesTheAirOutOfASkateboard) {
  const auto left = carve(skateboard_body(), kSkateboardBox);
  ASSERT_TRUE(left);
  const MeshSolid solid(left->points, left->triangles);
  EXPECT_EQ(solid.kind(), MeshKind::closed);
  EXPECT_GT(iou_with_skateboard(solid), 0.6);  // the box itself: 0.24
}

// Seen from above alone, up to three sigmas (22 mm) of air stay on a plate; the points of its surface tell
// it.
TEST(BodyCarving, GoesCloserByTheSurfaceSeen) {
  const RayBody plate = box_body("plate", {0.2, 0.2, 0.01});
  const Superellipsoid start{{0.2, 0.2, 0.05}, kBoxExponents};
  SurfaceFile seen;
  for (float x = -0.19F; x < 0.2F; x += 0.02F)
    for (float y = -0.19F; y < 0.2F; y += 0.02F) {
      seen.points.emplace_back(x, y, 0.01F);
      seen.normals.emplace_back(0, 0, 1);
    }
  const auto top_m = [&](const SurfaceFile& surface) {
    const auto left = carve(plate, start, 0.9, surface);
    return MeshSolid(left->points, left->triangles).box().max().z();
  };
  EXPECT_GT(top_m({}), 0.02);
  EXPECT_NEAR(top_m(seen), 0.01, 0.004);
}

TEST(BodyCarving, LeavesWhatNobodySawThrough) {
  const auto left = carve(skateboard_body(), kSkateboardBox, 0.7);  // from above
  ASSERT_TRUE(left);
  const MeshSolid solid(left->points, left->triangles);
  const Eigen::Vector3d below_the_deck(0, 0, 0.01), beside_the_wheels(0.39, 0.09, -0.045);
  EXPECT_EQ(solid.contains(std::array{below_the_deck, beside_the_wheels}), (std::vector<char>{1, 0}));
}

TEST(BodyCarving, LeavesConvexBodiesAsTheyAre) {
  const Eigen::Vector3d half(0.2, 0.1, 0.08);
  EXPECT_FALSE(carve(box_body("box", half), {half, kBoxExponents}));
  EXPECT_FALSE(carve(ellipsoid_body("egg", half), {half}));
  EXPECT_FALSE(carve(box_body("slab", {0.2, 0.2, 0.002}), {{0.2, 0.2, 0.002}, kBoxExponents}));
}

TEST(BodyCarving, WithoutViewsNothingIsFree) {
  EXPECT_FALSE(BodyCarving(kSkateboardBox, kNoise, kOptions).carved({}));
}

}  // namespace
}  // namespace uniquadric
