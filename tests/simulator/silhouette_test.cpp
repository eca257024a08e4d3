// How much of each body is in view, and the part of the image that is searched for it.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/render/box_pixels.h"
#include "simulator/render/renderer.h"
#include "tests/simulator/simple_scene.h"

namespace uniquadric {
namespace {

TEST(Renderer, VisibleFractionOfAKnownOcclusion) {
  // A screen that ends at x = 0 hides the left half of a square behind it; columns 0..49 of 100 are its.
  const Eigen::Vector3d screen_axes(1, 1, 0.01), square_axes(0.2, 0.1, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.objects = {make_body(1, box_mesh(square_axes), square_axes, Motion()),
                   make_body(2, box_mesh(screen_axes), screen_axes, Motion())};
  const auto at = [](double x, double y, double z) {
    return Pose{Eigen::Quaterniond::Identity(), {x, y, z}};
  };
  Renderer renderer(scene);
  const auto frame = renderer.render({Pose(), {at(0, 0, 1.01), at(-1, 0, 0.51)}});
  // front face at z = 1 m: 40 x 20 px, half of it hidden
  EXPECT_EQ(frame.objects[0].silhouette_px, 40 * 20);
  EXPECT_EQ(frame.objects[0].visible_px, 20 * 20);
  EXPECT_EQ(frame.objects[0].visible_fraction(), 0.5);
  EXPECT_FALSE(frame.objects[0].touches_border);
  EXPECT_EQ(frame.objects[1].silhouette_px, 50 * 80);
  EXPECT_EQ(frame.objects[1].visible_fraction(), 1);
  EXPECT_TRUE(frame.objects[1].touches_border);
}

TEST(Renderer, OutsideTheImageCountsAsNeitherSeenNorHidden) {
  const Eigen::Vector3d axes(0.2, 0.1, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  scene.objects = {make_body(1, box_mesh(axes), axes, Motion())};
  Renderer renderer(scene);
  const auto view = [&](double x, double z) {
    return renderer.render({Pose(), {{Eigen::Quaterniond::Identity(), {x, 0, z}}}}).objects[0];
  };
  const ObjectView cut = view(0.5, 1.01);  // its middle stands on the right border
  EXPECT_EQ(cut.visible_fraction(), 1);
  EXPECT_TRUE(cut.touches_border);
  EXPECT_NEAR(static_cast<double>(cut.silhouette_px), 20 * 20, 20);  // a column more: the side face shows
  const ObjectView behind = view(0, -1);
  EXPECT_EQ(behind.silhouette_px, 0);
  EXPECT_EQ(behind.visible_fraction(), 0);
  EXPECT_FALSE(behind.touches_border);
}

TEST(Renderer, SilhouettesOfMoreThanEightObjects) {
  const Eigen::Vector3d axes(0.04, 0.04, 0.01);
  Scene scene;
  scene.camera = {100, 80, 100, 100, 49.5, 39.5, {}};
  ScenePoses poses;
  for (int i = 0; i < 9; ++i) {  // all behind one another, the last one nearest
    scene.objects.push_back(make_body(65535 - i, box_mesh(axes), axes, Motion()));
    poses.world_from_object.push_back({Eigen::Quaterniond::Identity(), {0, 0, 2.01 - 0.1 * i}});
  }
  const auto frame = Renderer(scene).render(poses);
  for (int i = 0; i < 9; ++i) {
    const double side_px = 8 / (2 - 0.1 * i);
    EXPECT_NEAR(std::sqrt(static_cast<double>(frame.objects[i].silhouette_px)), side_px, 1) << i;
    EXPECT_EQ(frame.objects[i].id, 65535 - i);
    EXPECT_EQ(frame.objects[i].visible_fraction() > 0.99, i == 8) << i;
  }
}

// The box around a body may not lose a pixel of it, wherever it stands.
TEST(PixelsOfBox, HoldEveryPixelOfTheBody) {
  Scene scene = two_boxes();
  const Eigen::Vector3d axes(0.3, 0.2, 0.1);
  const Eigen::AlignedBox3f box(-axes.cast<float>(), axes.cast<float>());
  scene.world.clear();
  scene.objects = {make_body(1, box_mesh(axes), axes, Motion())};
  Renderer renderer(scene);
  int cut = 0, tight = 0, whole = 0, empty = 0;
  for (int i = 0; i < 150; ++i) {
    const Pose pose{exp_so3(Eigen::Vector3d(0.1 * i, 0.07 * i, 0.05 * i)),
                    {0.8 * std::sin(1.3 * i), 0.5 * std::sin(2.1 * i), 1.3 + 1.25 * std::sin(0.7 * i)}};
    const RenderedFrame& frame = renderer.render({Pose(), {pose}});
    const cv::Rect part = pixels_of_box(box, pose, scene.camera, 0.01);
    const std::int64_t all = cv::countNonZero(frame.ids);
    EXPECT_EQ(frame.objects[0].silhouette_px, all) << i;
    EXPECT_EQ(part.empty() ? 0 : cv::countNonZero(frame.ids(part)), all) << i;
    empty += part.empty();
    whole += part.size() == frame.ids.size();
    cut += frame.objects[0].touches_border;
    if (all == 0 || frame.objects[0].touches_border) continue;
    const cv::Rect seen = cv::boundingRect(frame.ids > 0);  // a box's corners are its outermost points
    EXPECT_LE(part.width, seen.width + 6) << i;
    EXPECT_LE(part.height, seen.height + 6) << i;
    ++tight;
  }
  EXPECT_GT(tight, 10);
  EXPECT_GT(cut, 5);
  EXPECT_GT(whole, 2);
  EXPECT_GT(empty, 2);
}

}  // namespace
}  // namespace uniquadric
