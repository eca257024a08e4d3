// The two benchmark scenes keep what they promise: checked on poses and boxes alone, without a renderer.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simulator/scene/scene.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

constexpr double kDegrees = 180 / std::numbers::pi;

struct Views {
  int frames = 0, whole = 0;               ///< frames, and those with the whole tight box on the image
  double nearest_m = 1e9, farthest_m = 0;  ///< from the optical centre
  double path_m = 0, turn_rad = 0;         ///< of the object in the world
  double arc_rad = 0;                      ///< largest angle between two directions it is seen from
  double lowest_m = 1e9;                   ///< of its box's corners above the floor
};

std::array<Eigen::Vector3d, 8> box_corners(const Body& body, const Pose& to_from_object) {
  std::array<Eigen::Vector3d, 8> corners;
  for (int k = 0; k < 8; ++k) {
    const Eigen::Vector3d sign(k & 1 ? 1 : -1, k & 2 ? 1 : -1, k & 4 ? 1 : -1);
    corners[k] = to_from_object * Eigen::Vector3d(sign.cwiseProduct(body.semi_axes_m));
  }
  return corners;
}

Eigen::AlignedBox2d image_box(const Scene& scene, const Body& body, double time_s) {
  Eigen::AlignedBox2d box;
  const Pose camera_from_object = scene.camera_motion.at(time_s).inverse() * body.motion.at(time_s);
  for (const auto& corner : box_corners(body, camera_from_object)) {
    const auto pixel = scene.camera.project(corner);
    if (!pixel) return {};
    box.extend(*pixel);
  }
  return box;
}

Views watch(const Scene& scene, const Body& body) {
  Views views;
  std::vector<Eigen::Vector3d> directions;
  Pose before;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
    const double time_s = static_cast<double>(scene.stamp_ns(frame)) * 1e-9;
    const Pose world_from_object = body.motion.at(time_s);
    const Eigen::Vector3d eye = world_from_object.inverse() * scene.camera_motion.at(time_s).translation;
    const Eigen::AlignedBox2d box = image_box(scene, body, time_s);
    ++views.frames;
    views.whole += !box.isEmpty() && scene.camera.contains(box.min()) && scene.camera.contains(box.max());
    views.nearest_m = std::min(views.nearest_m, eye.norm());
    views.farthest_m = std::max(views.farthest_m, eye.norm());
    for (const auto& corner : box_corners(body, world_from_object))
      views.lowest_m = std::min(views.lowest_m, corner.z());
    if (frame > 0) {
      views.path_m += (world_from_object.translation - before.translation).norm();
      views.turn_rad += log_so3(before.rotation.conjugate() * world_from_object.rotation).norm();
    }
    before = world_from_object;
    directions.push_back(eye.normalized());
  }
  for (const auto& a : directions)
    for (const auto& b : directions)
      views.arc_rad = std::max(views.arc_rad, std::acos(std::clamp(a.dot(b), -1.0, 1.0)));
  return views;
}

double overlapping_share(const Scene& scene) {
  int overlaps = 0;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
    const double time_s = static_cast<double>(scene.stamp_ns(frame)) * 1e-9;
    overlaps +=
        image_box(scene, scene.objects[0], time_s).intersects(image_box(scene, scene.objects[1], time_s));
  }
  return static_cast<double>(overlaps) / static_cast<double>(scene.frames);
}

double least_gap_m(const Scene& scene) {  // of the bodies' enclosing spheres; below 0 they might touch
  double gap = 1e9;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
    const double time_s = static_cast<double>(scene.stamp_ns(frame)) * 1e-9;
    const Body &a = scene.objects[0], &b = scene.objects[1];
    const double apart = (a.motion.at(time_s).translation - b.motion.at(time_s).translation).norm();
    gap = std::min(
        gap, apart - a.semi_axes_m.norm() - (b.shape == "ball" ? b.semi_axes_m.x() : b.semi_axes_m.norm()));
  }
  return gap;
}

class BenchmarkScene : public testing::TestWithParam<std::string> {};

TEST_P(BenchmarkScene, ShowsEachObjectWholeAndFromManySides) {
  constexpr double kMaxPenetration_m = 1e-3;  // under half a pixel at 1 m
  const Scene scene = load_scene(scene_test::kSource / "scenes" / GetParam());
  ASSERT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.frames, 300);
  for (const Body& body : scene.objects) {
    const Views views = watch(scene, body);
    SCOPED_TRACE(body.name);
    EXPECT_EQ(views.frames, 300);
    EXPECT_GE(views.whole, 0.95 * views.frames);
    EXPECT_GE(views.arc_rad * kDegrees, 60);
    EXPECT_GE(views.nearest_m, 1.4);
    EXPECT_LE(views.farthest_m, 3.6);
    EXPECT_GE(views.path_m, 2);
    EXPECT_GE(views.turn_rad * kDegrees, 120);
    if (body.shape != "ball") {  // whose box turns with it
      EXPECT_GE(views.lowest_m, -kMaxPenetration_m);
    }
    printf(
        "%s: whole in %d of %d frames, %.2f-%.2f m away, arc %.0f deg, path %.1f m, turn %.0f deg, lowest "
        "%.4f m\n",
        body.name.c_str(), views.whole, views.frames, views.nearest_m, views.farthest_m,
        views.arc_rad * kDegrees, views.path_m, views.turn_rad * kDegrees, views.lowest_m);
  }
  EXPECT_LE(overlapping_share(scene), 0.15);
  EXPECT_GE(least_gap_m(scene), 0);
  printf("boxes overlap in %.0f %% of the frames, least gap %.3f m\n", 100 * overlapping_share(scene),
         least_gap_m(scene));
}

INSTANTIATE_TEST_SUITE_P(Scenes, BenchmarkScene, testing::Values("cube_cuboid.yaml", "skateboard_ball.yaml"),
                         [](const auto& scene) { return scene.param.substr(0, scene.param.find('.')); });

}  // namespace
}  // namespace uniquadric
