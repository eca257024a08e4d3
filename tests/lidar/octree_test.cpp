#include <gtest/gtest.h>

#include <cmath>

#include "simulator/lidar/depth_octree.h"
#include "simulator/scene/named_motions.h"
#include "tests/lidar/lidar_support.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kResolution_m = 0.1;

// Lidar frame to optical frame.
const Pose kLidarFromCamera{Eigen::Quaterniond(0.5, -0.5, 0.5, -0.5), Vector3d::Zero()};

cv::Mat flat_depth(const Camera& camera, float z_m) {
  return cv::Mat(camera.height, camera.width, CV_32FC1, cv::Scalar(z_m));
}

TEST(DepthOctree, RangesLieWithinACellOfTheWall) {
  constexpr double kDistance_m = 7.53;
  const Camera camera = camera_of_field(75, 80, 600);
  const DepthOctree octree(flat_depth(camera, static_cast<float>(kDistance_m)), camera, kLidarFromCamera,
                           kResolution_m, 100);
  const LidarRig rig = exact_rig(named_pattern("livox_avia"));
  const LidarScan scan = take_octree_scan(octree, rig, 0);
  EXPECT_EQ(scan.points.size(), static_cast<std::size_t>(scan.beams));
  const RayCaster caster(
      {}, {body(1, square(100), static_motion({Eigen::Quaterniond::Identity(), {kDistance_m, 0, 0}}))});
  const LidarScan truth = take_scan(
      caster, rig, [](double) { return Pose{}; }, 0, 0);
  const RangeComparison compared = compare_ranges(scan, truth);
  EXPECT_EQ(compared.matched, scan.beams);
  EXPECT_EQ(compared.completeness(), 1);
  // A cell is entered before the surface in it, by at most its edge along x: 7.5 lies 0.03 m before the wall.
  EXPECT_LT(compared.mean_m, -0.03);
  EXPECT_GT(compared.mean_m, -0.05);
  EXPECT_LT(compared.p95_abs_m, kResolution_m);
}

TEST(DepthOctree, SeesNothingWhereTheImageHasNothing) {
  const Camera camera = camera_of_field(90, 60, 400);
  cv::Mat depth = flat_depth(camera, 4);
  depth.colRange(200, 400).setTo(0);  // the right half
  const DepthOctree octree(depth, camera, kLidarFromCamera, kResolution_m, 100);
  EXPECT_FALSE(octree.cast(Vector3d::Zero(), Vector3d(1, -0.3, 0).normalized()));
  const auto left = octree.cast(Vector3d::Zero(), Vector3d(1, 0.3, 0).normalized());
  ASSERT_TRUE(left);
  EXPECT_NEAR(*left, 4 * std::hypot(1, 0.3), kResolution_m);
  const DepthOctree near(depth, camera, kLidarFromCamera, kResolution_m, 3);
  EXPECT_FALSE(near.cast(Vector3d::Zero(), Vector3d(1, 0.3, 0).normalized()));
  EXPECT_NE(input_error([&] { DepthOctree(depth.rowRange(0, 9), camera, {}, 0.1, 9); }).find("400x9"),
            std::string::npos);
}

TEST(DepthOctree, CameraSeesTheField) {
  const Camera camera = camera_of_field(70.4, 77.2, 640);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(camera.contains(
        *camera.project({side * std::tan(35.19 * kDegree), side * std::tan(38.59 * kDegree), 1})));
    EXPECT_FALSE(camera.contains(*camera.project({side * std::tan(35.5 * kDegree), 0, 1})));
  }
}

TEST(RangeComparison, CountsLostExtraAndErrors) {
  LidarScan a{.start_ns = 0, .beams = 5, .points = {}, .truth = {}}, b = a;
  const auto add = [](LidarScan& scan, std::uint32_t offset, std::uint16_t ring, float range) {
    scan.points.push_back({0, 0, 0, 0, offset, ring, 0});
    scan.truth.push_back({range, 1, 0, LidarPointTruth::Kind::surface});
  };
  add(a, 0, 0, 1.0f);
  add(a, 0, 1, 2.5f);
  add(a, 20, 0, 9.0f);
  add(b, 0, 0, 1.25f);
  add(b, 0, 1, 2.0f);
  add(b, 10, 0, 3.0f);
  add(b, 30, 0, 3.0f);
  const RangeComparison result = compare_ranges(a, b, 0.25, 3);
  EXPECT_EQ(result.beams, 5);
  EXPECT_EQ(result.matched, 2);
  EXPECT_EQ(result.lost, 2);
  EXPECT_EQ(result.extra, 1);
  EXPECT_EQ(result.completeness(), 0.5);
  EXPECT_EQ(result.mean_m, 0.125);
  EXPECT_EQ(result.rms_m, std::sqrt((0.0625 + 0.25) / 2));
  EXPECT_EQ(result.histogram, (std::vector<std::int64_t>{1, 0, 1}));
}

}  // namespace
}  // namespace uniquadric
