#include "estimator/ego/world_frame.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace uniquadric {
namespace {

constexpr double kFloor_m = 1.4, kWall_m = 5;  // below and before the camera

// Depth of a floor and a wall, seen by a camera whose world's axes are (right, forward, up).
cv::Mat room_depth(const Camera& camera, const Pose& world_from_camera, bool with_floor, double noise) {
  cv::Mat depth = cv::Mat::zeros(camera.height, camera.width, CV_32FC1);
  RandomStream random(1, "room");
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      const Eigen::Vector3d ray = world_from_camera.rotation * *camera.unproject(Eigen::Vector2d(u, v));
      double z = ray.y() > 0 ? kWall_m / ray.y() : 0;
      if (with_floor && ray.z() < 0 && (z == 0 || -kFloor_m / ray.z() < z)) z = -kFloor_m / ray.z();
      depth.at<float>(v, u) = float(z * (1 + noise * random.normal()));
    }
  return depth;
}

// Looks along the world's y, pitched down and rolled.
Pose camera_pose(double down_rad, double roll_rad) {
  Eigen::Matrix3d level;
  level << 1, 0, 0, 0, 0, 1, 0, -1, 0;  // columns: right, down, forward
  return {Eigen::Quaterniond(level) * exp_so3({-down_rad, 0, 0}) * exp_so3({0, 0, roll_rad}),
          Eigen::Vector3d::Zero()};
}

TEST(WorldFrame, UpIsTheFloorsNormal) {
  const Camera camera;
  int tried = 0;
  for (const double down : {0.0, 0.3, 0.7})
    for (const double roll : {-0.3, 0.0, 0.2}) {
      RandomStream random(2, "test");
      const Pose pose = camera_pose(down, roll);
      const auto up = find_up(room_depth(camera, pose, true, 0.005), {}, camera, {}, random);
      ASSERT_TRUE(up) << down << " " << roll;
      EXPECT_LT((pose.rotation * *up - Eigen::Vector3d::UnitZ()).norm(), 0.01);
      ++tried;
    }
  EXPECT_EQ(tried, 9);
}

TEST(WorldFrame, AWallIsNoFloor) {
  const Camera camera;
  RandomStream random(2, "test");
  EXPECT_FALSE(find_up(room_depth(camera, camera_pose(0.1, 0.1), false, 0.005), {}, camera, {}, random));
  EXPECT_FALSE(find_up({}, {}, camera, {}, random));
  EXPECT_FALSE(find_up(cv::Mat::zeros(480, 640, CV_32FC1), {}, camera, {}, random));
  const cv::Mat all_masked(480, 640, CV_16UC1, cv::Scalar(1));
  EXPECT_FALSE(find_up(room_depth(camera, camera_pose(0.3, 0), true, 0), all_masked, camera, {}, random));
}

TEST(WorldFrame, TheCameraStandsAtTheOriginUpright) {
  const Eigen::Vector3d up = Eigen::Vector3d(0.2, -0.9, -0.3).normalized();
  const Pose pose = upright_world_from_camera(up);
  EXPECT_LT((pose.rotation * up - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  EXPECT_NEAR((pose.rotation * Eigen::Vector3d::UnitX()).y(), 0, 1e-12);
  EXPECT_GT((pose.rotation * Eigen::Vector3d::UnitX()).x(), 0.9);
  EXPECT_GT((pose.rotation * Eigen::Vector3d::UnitZ()).y(), 0.9);  // forward
  EXPECT_EQ(pose.translation, Eigen::Vector3d(0, 0, 0));
}

}  // namespace
}  // namespace uniquadric
