// The scenes keep what they promise: checked on poses and boxes alone, without a renderer.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <ostream>
#include <string>
#include <vector>

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

// Whether the segment from a to b meets the box [-half, half] (slabs).
bool crosses_box(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& half) {
  double enter = 0, leave = 1;
  for (int k = 0; k < 3; ++k) {
    const double way = b[k] - a[k];
    if (std::abs(way) < 1e-12) {
      if (std::abs(a[k]) > half[k]) return false;
      continue;
    }
    const double first = (-half[k] - a[k]) / way, second = (half[k] - a[k]) / way;
    enter = std::max(enter, std::min(first, second));
    leave = std::min(leave, std::max(first, second));
  }
  return enter < leave;
}

// Whether a body fills its box; rooms, streets and planes do not.
bool is_solid(const Body& body) {
  return body.id > 0 || body.shape == "rounded_box" || body.shape == "box";
}

// Separating axes of two oriented boxes: the widest gap along any of the 15 directions, below 0 when they
// meet (Gottschalk, Lin and Manocha, "OBBTree", SIGGRAPH 1996).
double gap_m(const Body& a, const Body& b, double time_s) {
  const auto corners_a = box_corners(a, a.motion.at(time_s)), corners_b = box_corners(b, b.motion.at(time_s));
  const Eigen::Matrix3d Ra = a.motion.at(time_s).rotation.toRotationMatrix(),
                        Rb = b.motion.at(time_s).rotation.toRotationMatrix();
  std::vector<Eigen::Vector3d> axes;
  for (int i = 0; i < 3; ++i) {
    axes.push_back(Ra.col(i));
    axes.push_back(Rb.col(i));
    for (int j = 0; j < 3; ++j)
      if (const Eigen::Vector3d across = Ra.col(i).cross(Rb.col(j)); across.norm() > 1e-6)
        axes.push_back(across.normalized());
  }
  double gap = -1e9;
  for (const Eigen::Vector3d& axis : axes) {
    Eigen::AlignedBox1d on_a, on_b;
    for (const auto& corner : corners_a) on_a.extend(Eigen::Matrix<double, 1, 1>(axis.dot(corner)));
    for (const auto& corner : corners_b) on_b.extend(Eigen::Matrix<double, 1, 1>(axis.dot(corner)));
    gap = std::max({gap, (on_a.min() - on_b.max())[0], (on_b.min() - on_a.max())[0]});
  }
  return gap;
}

double least_gap_m(const Scene& scene) {
  double gap = 1e9;
  std::vector<Body> others;  // that stand in a room: the room itself is open
  for (const Body& body : scene.world)
    if (is_solid(body)) others.push_back(body);
  for (std::size_t a = 0; a < scene.objects.size(); ++a) {
    others.push_back(scene.objects[a]);
    for (std::int64_t frame = 0; frame < scene.frames; ++frame)
      for (std::size_t b = 0; b + 1 < others.size(); ++b)
        gap = std::min(gap,
                       gap_m(scene.objects[a], others[b], static_cast<double>(scene.stamp_ns(frame)) * 1e-9));
  }
  return gap;
}

// Share of points on the body's box, on the sides that face the camera, to which the sight is free of the
// other bodies' boxes.
double visible_share(const Scene& scene, const Body& body, double time_s) {
  const Eigen::Vector3d eye = scene.camera_motion.at(time_s).translation;
  const Pose world_from_object = body.motion.at(time_s);
  const Eigen::Vector3d eye_in_object = world_from_object.inverse() * eye;
  std::vector<const Body*> others;
  for (const auto* list : {&scene.world, &scene.objects})
    for (const Body& other : *list)
      if (&other != &body && is_solid(other)) others.push_back(&other);
  constexpr int kSide = 12;
  int seen = 0, points = 0;
  for (int face = 0; face < 3; ++face) {
    const double sign = eye_in_object[face] < 0 ? -1 : 1;
    if (std::abs(eye_in_object[face]) <= body.semi_axes_m[face]) continue;
    for (int k = 0; k < kSide * kSide; ++k, ++points) {
      Eigen::Vector3d p = sign * body.semi_axes_m;
      p[(face + 1) % 3] *= 2.0 * (k % kSide) / (kSide - 1) - 1;
      p[(face + 2) % 3] *= 2.0 * (k / kSide) / (kSide - 1) - 1;
      const Eigen::Vector3d point = world_from_object * p;
      seen += std::none_of(others.begin(), others.end(), [&](const Body* other) {
        const Pose other_from_world = other->motion.at(time_s).inverse();
        return crosses_box(other_from_world * eye, other_from_world * point, other->semi_axes_m);
      });
    }
  }
  return static_cast<double>(seen) / points;
}

// Share of the frames in which nine tenths of the body's facing sides are seen.
double freely_seen_share(const Scene& scene, const Body& body) {
  constexpr double kFree = 0.9;
  int free = 0;
  for (std::int64_t frame = 0; frame < scene.frames; ++frame)
    free += visible_share(scene, body, static_cast<double>(scene.stamp_ns(frame)) * 1e-9) >= kFree;
  return static_cast<double>(free) / static_cast<double>(scene.frames);
}

/// What a scene must show of every object.
struct Promise {
  std::string scene;
  std::size_t objects;
  std::int64_t frames;
  double whole_share;            ///< of the frames: the whole box is on the image
  double arc_deg;                ///< at least
  double nearest_m, farthest_m;  ///< all views lie between
  double path_m, turn_deg;       ///< at least
  double freely_seen;            ///< of the frames, at least: no more than a tenth is hidden
};
std::ostream& operator<<(std::ostream& out, const Promise& promise) {
  return out << promise.scene;
}

class SceneOfThePaper : public testing::TestWithParam<Promise> {};

TEST_P(SceneOfThePaper, ShowsEachObjectWholeAndFromManySides) {
  constexpr double kMaxPenetration_m = 1e-3;  // under half a pixel at 1 m
  const Promise& promise = GetParam();
  const Scene scene = load_scene(scene_test::kSource / "scenes" / (promise.scene + ".yaml"));
  ASSERT_EQ(scene.objects.size(), promise.objects);
  EXPECT_EQ(scene.frames, promise.frames);
  for (const Body& body : scene.objects) {
    const Views views = watch(scene, body);
    SCOPED_TRACE(body.name);
    EXPECT_EQ(views.frames, promise.frames);
    EXPECT_GE(views.whole, promise.whole_share * views.frames);
    EXPECT_GE(views.arc_rad * kDegrees, promise.arc_deg);
    EXPECT_GE(views.nearest_m, promise.nearest_m);
    EXPECT_LE(views.farthest_m, promise.farthest_m);
    EXPECT_GE(views.path_m, promise.path_m);
    EXPECT_GE(views.turn_rad * kDegrees, promise.turn_deg);
    if (body.shape != "ball") {  // whose box turns with it
      EXPECT_GE(views.lowest_m, -kMaxPenetration_m);
    }
    const double freely_seen = freely_seen_share(scene, body);
    EXPECT_GE(freely_seen, promise.freely_seen);
    printf(
        "%s: whole in %d of %d frames, %.2f-%.2f m away, arc %.0f deg, path %.1f m, turn %.0f deg, lowest "
        "%.4f m, freely seen %.2f\n",
        body.name.c_str(), views.whole, views.frames, views.nearest_m, views.farthest_m,
        views.arc_rad * kDegrees, views.path_m, views.turn_rad * kDegrees, views.lowest_m, freely_seen);
  }
  EXPECT_GE(least_gap_m(scene), 0);
  printf("least gap %.3f m\n", least_gap_m(scene));
}

INSTANTIATE_TEST_SUITE_P(Scenes, SceneOfThePaper,
                         testing::Values(Promise{"cube_cuboid", 2, 300, .95, 60, 1.4, 3.6, 2, 120, .95},
                                         Promise{"skateboard_ball", 2, 300, .95, 60, 1.4, 3.6, 2, 120, .9},
                                         Promise{"subway_car", 2, 300, .95, 40, 8, 40, 30, 10, .9},
                                         Promise{"swinging_4", 4, 500, .95, 60, 1.4, 4, 5, 360, .8},
                                         Promise{"occlusion_2", 2, 300, .95, 60, 1.4, 4.5, 2, 120, .4}),
                         [](const auto& tested) { return tested.param.scene; });

TEST(OcclusionScene, HidesEachBodyForOneToTwoSeconds) {
  const Scene scene = load_scene(scene_test::kSource / "scenes/occlusion_2.yaml");
  int hidings = 0;
  for (const Body& body : scene.objects) {
    int hidden = 0, longest = 0, own_hidings = 0;
    std::string pattern;
    for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
      const bool is_hidden =
          visible_share(scene, body, static_cast<double>(scene.stamp_ns(frame)) * 1e-9) == 0;
      if (is_hidden) own_hidings += hidden == 0;
      hidden = is_hidden ? hidden + 1 : 0;
      longest = std::max(longest, hidden);
      if (frame % 5 == 0) pattern += is_hidden ? '#' : '.';
    }
    SCOPED_TRACE(body.name);
    EXPECT_EQ(hidden, 0) << "is back at the end";
    EXPECT_GE(longest, scene.rate_hz);
    EXPECT_LE(longest, 2 * scene.rate_hz);
    hidings += own_hidings;
    printf("%s: hidden %d times, longest %.2f s %s\n", body.name.c_str(), own_hidings,
           longest / scene.rate_hz, pattern.c_str());
  }
  EXPECT_EQ(hidings, 3) << "the cube behind the cuboid and the cabinet, the cuboid behind the cabinet";
}

TEST(StreetScene, CarriesAllSensorsPastObjectsInTheLidarsView) {
  const Scene scene = load_scene(scene_test::kSource / "scenes/subway_car.yaml");
  EXPECT_TRUE(scene.imu);
  EXPECT_TRUE(scene.lidar);
  EXPECT_FALSE(scene.depth);
  constexpr double kHalfWidth = 0.70, kHalfHeight = 0.79;  // tan of half of 70 x 77 degrees
  for (const Body& body : scene.objects) {
    int inside = 0;
    for (std::int64_t frame = 0; frame < scene.frames; ++frame) {
      const double time_s = static_cast<double>(scene.stamp_ns(frame)) * 1e-9;
      const Eigen::Vector3d centre =
          (scene.camera_motion.at(time_s).inverse() * body.motion.at(time_s)).translation;
      inside +=
          std::abs(centre.x()) < kHalfWidth * centre.z() && std::abs(centre.y()) < kHalfHeight * centre.z();
    }
    EXPECT_EQ(inside, scene.frames) << body.name;
  }
}

}  // namespace
}  // namespace uniquadric
