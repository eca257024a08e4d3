#include "estimator/features/surface_descriptor.h"

#include <gtest/gtest.h>

#include "drawn_world.h"
#include "estimator/features/corners.h"

namespace uniquadric {
namespace {

TEST(SurfaceDescriptor, TheNormalIsThatOfThePlane) {
  const Camera camera = small_camera();
  const Eigen::Vector3d normal = Eigen::Vector3d(0.3, -0.4, -0.8).normalized(), middle(0.1, 0.05, 2);
  const auto inverse_depth = [&](const Eigen::Vector2d& p) {
    return normal.dot(*camera.unproject(p)) / normal.dot(middle);
  };
  const Eigen::Vector2d pixel = *camera.project(middle);
  PlaneDepth plane;
  plane.depth_m = 2;
  plane.slope_per_px = {inverse_depth(pixel + Eigen::Vector2d(1, 0)) - 0.5,
                        inverse_depth(pixel + Eigen::Vector2d(0, 1)) - 0.5};
  EXPECT_LT((surface_normal(camera, pixel, plane) - normal).norm(), 1e-12);
}

// A card seen from the front and turned by 50 degrees, nearer and rolled: most corners' nearest descriptor is
// that of the same point.
TEST(SurfaceDescriptor, KnowsAPointFromAnotherSide) {
  const Camera camera = small_camera();
  const std::vector<DrawnCard> card{{0, {2, 1.6}, block_texture(700, 8), {}}};
  const Pose front{exp_so3({0, 0, 0}), {0, 0, 1.7}}, side{exp_so3({0.2, 0.85, 0.4}), {0, 0, 1.4}};
  const auto a = draw(camera, moved(card, front), {0, 2}, 0), b = draw(camera, moved(card, side), {0, 2}, 1);
  std::vector<SurfacePoint> in_a, in_b;
  for (const auto& corner : fast_corners(a.gray, 30)) {
    const auto surface = fit_plane_depth(a.depth, {}, corner.pixel, {});
    if (!surface || in_a.size() >= 60) continue;
    const Eigen::Vector3d point = surface->depth_m * *camera.unproject(corner.pixel);
    const auto pixel = camera.project(side * (front.inverse() * point));
    if (!pixel || !camera.contains(*pixel)) continue;
    const auto surface_b = fit_plane_depth(b.depth, {}, *pixel, {});
    if (!surface_b) continue;
    in_a.push_back({corner.pixel, *surface});
    in_b.push_back({*pixel, *surface_b});
  }
  ASSERT_GT(in_a.size(), 40u);
  const auto of_a = describe_surfaces(a.gray, camera, in_a), of_b = describe_surfaces(b.gray, camera, in_b);
  int right = 0;
  for (std::size_t i = 0; i < of_a.size(); ++i) {
    std::size_t best = 0;
    for (std::size_t k = 0; k < of_b.size(); ++k)
      if (descriptor_distance(of_a[i], of_b[k]) < descriptor_distance(of_a[i], of_b[best])) best = k;
    right += (in_b[best].pixel - in_b[i].pixel).norm() < 4;
  }
  EXPECT_GT(right, 0.6 * double(of_a.size()));
}

TEST(SurfaceDescriptor, HasNoneForASurfaceSeenEdgeOn) {
  PlaneDepth steep;
  steep.depth_m = 2;
  steep.slope_per_px = {0.01, 0};  // 1/m a pixel: 80 degrees
  const cv::Mat gray(240, 320, CV_8UC1, cv::Scalar(80));
  EXPECT_TRUE(describe_surfaces(gray, small_camera(), {{{160, 120}, steep}})[0].empty());
  EXPECT_TRUE(describe_surfaces(gray, small_camera(), {}).empty());
  EXPECT_EQ(descriptor_distance({}, {}), 257);
}

}  // namespace
}  // namespace uniquadric
