#include "estimator/shape/object_points.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "box_scene.h"

namespace uniquadric {
namespace {

const Camera kCamera{320, 240, 260, 260, 159.5, 119.5, {}};

TEST(ObjectPoints, LieOnTheSurfaceThatTheDepthShows) {
  const OrientedBox box = scene_box(0);
  const Pose world_from_camera = scene_camera(0);
  RandomStream random(1, "image");
  const BoxImage image = render_box(kCamera, world_from_camera, box, random);
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
  const Eigen::Matrix3Xd points = object_points(depth, image.mask == 1, kCamera, PointOptions{});
  ASSERT_GT(points.cols(), 500);
  // Half a depth step of 0.2 mm, and the mean of a voxel across an edge of the box: at most half a voxel's
  // diagonal.
  const double kFace = 2e-4, kEdge = 0.5 * std::sqrt(3) * PointOptions{}.voxel_m;
  Eigen::Index on_face = 0;
  for (const auto& p : points.colwise()) {
    const double distance = distance_to_surface(box, world_from_camera * Eigen::Vector3d(p));
    EXPECT_LT(distance, kEdge);
    on_face += distance < kFace;
  }
  EXPECT_GT(on_face, 9 * points.cols() / 10);
}

TEST(ObjectPoints, PixelsAtDepthEdgesAndTheMasksRimAreLeftOut) {
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(3));
  depth(cv::Rect(100, 80, 60, 50)).setTo(2);  // a plate before a wall
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
  mask(cv::Rect(90, 70, 80, 70)).setTo(255);  // a mask that is 10 px too large
  PointOptions options;
  options.erode_px = 0;
  options.voxel_m = 1e-4;  // every pixel by itself
  options.outlier_rounds = 0;
  options.max_points = 1'000'000;
  // The plate's outline (2 * 60 + 2 * 48 px) and the wall's pixels around it (2 * 60 + 2 * 50) stand at the
  // edge.
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 80 * 70 - (120 + 96) - (120 + 100));
  options.edge_ratio = 10;
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 80 * 70);
  options.erode_px = 3;
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 74 * 64);
  options.max_depth_m = 2.5;
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 60 * 50);
}

TEST(ObjectPoints, FewerThanTheLeastAreNone) {
  const cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(2));
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
  mask(cv::Rect(10, 10, 8, 8)).setTo(255);
  PointOptions options;
  options.erode_px = 2;  // leaves 16 px
  options.voxel_m = 1e-4;
  options.min_points = 16;
  options.outlier_rounds = 0;
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 16);
  options.min_points = 17;
  EXPECT_EQ(object_points(depth, mask, kCamera, options).cols(), 0);
}

TEST(ObjectPoints, VoxelsHoldTheMeanOfTheirPoints) {
  Eigen::Matrix3Xd points(3, 4);
  points << 0.01, 0.03, -0.01, 0.95, 0, 0.02, 0, 0, 0, 0.04, 0, 0;
  const Eigen::Matrix3Xd means = voxel_means(points, 0.1);
  ASSERT_EQ(means.cols(), 3);  // -0.01 lies in another cube than 0.01
  EXPECT_LT((means.col(1) - Eigen::Vector3d(0.02, 0.01, 0.02)).norm(), 1e-15);
}

TEST(ObjectPoints, OutliersGoAndTheSurfaceStays) {
  RandomStream random(2, "outliers");
  Eigen::Matrix3Xd cloud = box_cloud(generic_box({0.2, 0.2, 0.2}), {.spacing_m = 0.02}, random);
  const Eigen::Index clean = cloud.cols();
  cloud.conservativeResize(3, clean + 2);
  cloud.col(clean) = generic_box({}).center;  // the middle of the box: 0.2 m from anything
  cloud.col(clean + 1) = generic_box({}).center + Eigen::Vector3d(0, 0, 2);
  Eigen::Matrix3Xd kept = drop_outliers(drop_outliers(cloud, 12, 2.5), 12, 2.5);
  EXPECT_GT(kept.cols(), 9 * clean / 10);
  for (const auto& p : kept.colwise()) EXPECT_LT(distance_to_surface(generic_box({0.2, 0.2, 0.2}), p), 1e-9);
}

TEST(SmoothedPoints, LoseTheNoiseOfPixelsAndKnowTheirNormals) {
  const OrientedBox box = scene_box(0);
  const Pose world_from_camera = scene_camera(0);
  RandomStream random(1, "image"), noise(2, "noise");
  const BoxImage image = render_box(kCamera, world_from_camera, box, random);
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
  const double kNoise = 0.005;  // relative
  for (float& z : cv::Mat_<float>(depth)) z *= static_cast<float>(1 + kNoise * noise.normal());
  const SurfacePoints surface = smoothed_points(depth, image.mask == 1, kCamera, PointOptions{});
  ASSERT_GT(surface.points.cols(), 500);
  ASSERT_EQ(surface.normals.cols(), surface.points.cols());
  std::vector<double> distances, cosines;
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i) {
    const Eigen::Vector3d p = surface.points.col(i), n = surface.normals.col(i);
    EXPECT_NEAR(n.norm(), 1, 1e-12);
    EXPECT_LT(n.dot(p), 0);  // towards the camera
    distances.push_back(distance_to_surface(box, world_from_camera * p) / p.z());
    const Eigen::Vector3d in_box = box.axes.transpose() * (world_from_camera.rotation * n);
    cosines.push_back(in_box.cwiseAbs().maxCoeff());  // with the face that it is nearest to
  }
  std::sort(distances.begin(), distances.end());
  std::sort(cosines.begin(), cosines.end());
  EXPECT_LT(distances[distances.size() / 2], kNoise / 4);
  EXPECT_GT(cosines[cosines.size() / 2], std::cos(0.15));
}

TEST(SmoothedPoints, LeaveOutWhatAMaskTakesInBesideTheBody) {
  cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(3));
  depth(cv::Rect(100, 80, 60, 50)).setTo(2);  // a plate before a wall
  cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
  mask(cv::Rect(98, 78, 64, 54)).setTo(255);  // a mask that is 2 px too large
  const SurfacePoints surface = smoothed_points(depth, mask, kCamera, PointOptions{});
  ASSERT_GT(surface.points.cols(), 1000);
  for (const auto& p : surface.points.colwise()) EXPECT_NEAR(p.z(), 2, 1e-6);
}

// A mask of a plate and of as much again of what is behind: 0.65 m long at the plate, which then ends 1.9 m
// behind it.
TEST(SmoothedPoints, LeaveOutWhatIsTooFarToBeTheBody) {
  int cases = 0;
  for (const auto& [behind_m, is_body] : {std::pair(3.0, true), {4.0, false}}) {
    cv::Mat depth(240, 320, CV_32FC1, cv::Scalar(behind_m));
    depth(cv::Rect(100, 80, 51, 50)).setTo(1.5);
    cv::Mat mask = cv::Mat::zeros(240, 320, CV_8UC1);
    mask(cv::Rect(100, 80, 100, 50)).setTo(255);
    const SurfacePoints surface = smoothed_points(depth, mask, kCamera, PointOptions{});
    ASSERT_GT(surface.points.cols(), 1000);
    EXPECT_NEAR(surface.points.row(2).maxCoeff(), is_body ? behind_m : 1.5, 1e-6) << behind_m;
    ++cases;
  }
  EXPECT_EQ(cases, 2);
}

}  // namespace
}  // namespace uniquadric
