#include "tests/evaluation_report/browser_views.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "core/geometry/ellipsoid.h"
#include "evaluation/report/outline.h"

namespace uniquadric {
namespace {

using nlohmann::json;

Eigen::Vector3d vector(const json& v) {
  return Eigen::Vector3d(v[0], v[1], v[2]);
}

Pose pose_of(const json& pose) {
  return {Eigen::Quaterniond(pose[6], pose[3], pose[4], pose[5]).normalized(), vector(pose)};
}

using Outline = std::vector<Eigen::Vector2d>;

// The eye that the page says, as a camera of core's.
std::pair<Camera, Pose> eye_of(const json& painted) {
  const json& orbit = painted.at("orbit");
  const double yaw = orbit.at("yaw"), pitch = orbit.at("pitch"), distance = orbit.at("distance");
  const Eigen::Vector3d back(std::cos(pitch) * std::cos(yaw), std::cos(pitch) * std::sin(yaw),
                             std::sin(pitch));
  Eigen::Matrix3d world_from_eye;
  world_from_eye.col(2) = -back;
  world_from_eye.col(0) = (-back).cross(Eigen::Vector3d::UnitZ()).normalized();
  world_from_eye.col(1) = world_from_eye.col(2).cross(world_from_eye.col(0));
  const double width = painted.at("width"), height = painted.at("height");
  Camera camera;
  camera.fx = camera.fy = std::min(width, height) / 2 / std::tan(20 * std::numbers::pi / 180);
  camera.cx = width / 2, camera.cy = height / 2;
  return {camera, {Eigen::Quaterniond(world_from_eye), vector(orbit.at("target")) + distance * back}};
}

// The fabricated bodies (fabricated_results.cpp): object 1 is a mesh of four corners, estimated as a solid
// with three exponents about x; object 2 is a box.
Outline outline_of(const Camera& camera, const Pose& camera_from_object, const std::string& object,
                   bool truth, const Eigen::Vector3d& axes_m) {
  const bool first = object == "cuboid" || object == "skateboard";
  if (!first) return superellipsoid_outline(camera, camera_from_object, {axes_m, kBoxExponents, 2});
  if (!truth) return superellipsoid_outline(camera, camera_from_object, {axes_m, {1.5, 2, 1.2}, 0});
  Outline corners;
  for (const Eigen::Vector3d& corner :
       {Eigen::Vector3d(0.2, 0, 0), {-0.2, 0.15, 0}, {-0.2, -0.15, 0}, {0, 0, 0.1}})
    corners.push_back(*camera.project(camera_from_object * corner));
  return corners;
}

double reach(const Outline& outline, const Eigen::Vector2d& direction) {
  double most = -1e9;
  for (const Eigen::Vector2d& point : outline) most = std::max(most, direction.dot(point));
  return most;
}

// As far as each other in all directions, but for what the mesh of the page lacks.
void expect_alike(const json& points, const Outline& expected) {
  Outline painted;
  for (const json& point : points) painted.push_back(Eigen::Vector2d(point[0], point[1]));
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector2d direction(std::cos(i * std::numbers::pi / 18), std::sin(i * std::numbers::pi / 18));
    const double width = reach(expected, direction) + reach(expected, -direction);
    EXPECT_NEAR(reach(painted, direction), reach(expected, direction), 0.1 + 0.006 * width) << i;
  }
}

struct Expected {
  Outline in_space, in_film;
};

// Where the body of a page must be.
Expected expected_of(const json& painted, const json& body, const json& motion, const std::string& scene) {
  const auto index = painted.at("index").get<std::size_t>();
  const std::string label = body.at("label");
  for (const json& run : motion.at("runs")) {
    if (run.at("scene") != scene || (label.empty() ? run.at("seed") != 1 : run.at("variant") != label))
      continue;
    const json& truth = motion.at("truths")[run.at("truth").get<std::size_t>()];
    for (const json& track : (label.empty() ? truth : run).at("objects")) {
      if (track.at("object") != body.at("object")) continue;
      const auto [camera, eye] = eye_of(painted);
      const Pose object = pose_of(track.at("poses")[index]);
      const Eigen::Vector3d axes_m = vector(track.at("semi_axes_m")[0]);
      const double scale = painted.at("film_width").get<double>() / 640;
      Camera film;  // pixels' borders, not centres, lie at whole numbers of the page's
      film.fx = 525 * scale, film.fy = 520 * scale, film.cx = 321 * scale, film.cy = 238.5 * scale;
      const Pose film_eye = pose_of(truth.at("camera")[index]);
      return {outline_of(camera, eye.inverse() * object, track["object"], label.empty(), axes_m),
              outline_of(film, film_eye.inverse() * object, track["object"], label.empty(), axes_m)};
    }
  }
  return {};
}

Eigen::Vector2d middle_of(const json& body) {
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const json& point : body.at("outline")) sum += Eigen::Vector2d(point[0], point[1]);
  return sum / static_cast<double>(body.at("outline").size());
}

}  // namespace

int expect_painted(const json& painted, const json& motion, const std::string& scene) {
  int compared = 0;
  for (const json& body : painted.at("bodies")) {
    const Outline expected = expected_of(painted, body, motion, scene).in_space;
    if (expected.empty()) continue;
    expect_alike(body.at("outline"), expected);
    ++compared;
  }
  for (const json& body : painted.at("in_film"))
    if (const Outline expected = expected_of(painted, body, motion, scene).in_film; !expected.empty())
      expect_alike(body.at("outline"), expected);
  return compared;
}

void expect_solid_pixels(const json& space, const json& motion) {
  ASSERT_FALSE(space.at("solids").empty());
  for (const json& solid : space.at("solids")) {
    const Outline expected = expected_of(space.at("late"), solid, motion, "cube_cuboid").in_space;
    if (expected.empty()) continue;  // a track of no object
    std::vector<cv::Point2f> polygon;
    for (const Eigen::Vector2d& p : expected)
      polygon.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
    const double area = cv::contourArea(polygon);
    EXPECT_NEAR(solid.at("pixels").at("count"), area, 0.05 * area + 40) << solid;
    for (const json& pixels : {solid["pixels"], solid.at("in_lines")}) {
      EXPECT_NEAR(pixels.at("right"), reach(expected, Eigen::Vector2d::UnitX()), 2) << solid;
      EXPECT_NEAR(pixels.at("left"), -reach(expected, -Eigen::Vector2d::UnitX()), 2) << solid;
      EXPECT_NEAR(pixels.at("bottom"), reach(expected, Eigen::Vector2d::UnitY()), 2) << solid;
      EXPECT_NEAR(pixels.at("top"), -reach(expected, -Eigen::Vector2d::UnitY()), 2) << solid;
    }
  }
}

void expect_slider_moves_ellipsoids(const json& space, const json& motion) {
  const json &early = space.at("early"), &late = space.at("late");
  EXPECT_EQ(early.at("index"), 5);
  EXPECT_EQ(late.at("index"), 125);
  EXPECT_NE(early.at("picture"), late.at("picture"));
  EXPECT_NE(early.at("figures"), late.at("figures"));
  EXPECT_NE(early.at("film"), late.at("film"));
  EXPECT_EQ(early.at("frame"), "frame 0");  // of every tenth that is kept, the nearest
  EXPECT_EQ(late.at("frame"), "frame 120");
  EXPECT_EQ(early.at("in_film").size(), 5u);
  EXPECT_NEAR(space.at("mark_s"), 125 / 30., 1e-6);  // the mark in the plots went along
  // Two true bodies and two estimates; from frame 120 the first is lost.
  EXPECT_EQ(early.at("bodies").size(), 4u + 1u);  // and the stray track, in frames 0 to 9
  EXPECT_EQ(expect_painted(early, motion, "cube_cuboid"), 4);
  EXPECT_EQ(expect_painted(late, motion, "cube_cuboid"), 3);
  EXPECT_EQ(expect_painted(space.at("both"), motion, "cube_cuboid"), 4);
  EXPECT_EQ(expect_painted(space.at("dragged"), motion, "cube_cuboid"), 4);
  for (const char* painted : {"start", "early", "late"})  // all in the picture
    for (const json& body : space[painted].at("bodies")) {
      const Eigen::Vector2d middle = middle_of(body);
      EXPECT_GT(middle.minCoeff(), 0);
      EXPECT_LT(middle.x(), space[painted].at("width"));
      EXPECT_LT(middle.y(), space[painted].at("height"));
    }
}

void expect_turns_zooms_follows_and_plays(const json& space) {
  const json &before = space.at("before_drag").at("orbit"), &dragged = space.at("dragged").at("orbit");
  EXPECT_LT(dragged.at("yaw"), before.at("yaw"));
  EXPECT_GT(dragged.at("pitch"), before.at("pitch"));
  EXPECT_EQ(dragged.at("distance"), before.at("distance"));
  const json &wheeled = space.at("wheeled").at("orbit"), &pinched = space.at("pinched").at("orbit");
  EXPECT_LT(wheeled.at("distance"), dragged.at("distance"));
  EXPECT_EQ(space["wheeled"].at("stays"), true);
  // It lies near the depth that the zoom is about, and pointers have whole pixels.
  const json &aim = space["wheeled"].at("aim"), &aimed = space["wheeled"].at("aimed");
  EXPECT_NEAR(aimed.at("x").get<double>(), aim.at("x").get<double>(), 8);
  EXPECT_NEAR(aimed.at("y").get<double>(), aim.at("y").get<double>(), 8);
  EXPECT_NEAR(pinched.at("distance").get<double>(), wheeled.at("distance").get<double>() / 2, 1e-9);
  for (const json& body : space.at("followed").at("bodies"))
    if (body.at("object") == "cube" && body.at("label") == "") {
      EXPECT_NEAR(middle_of(body).x(), space["followed"].at("width").get<double>() / 2, 30);
      EXPECT_NEAR(middle_of(body).y(), space["followed"].at("height").get<double>() / 2, 30);
    }
  EXPECT_GT(space.at("played"), 0);
  EXPECT_LT(space.at("played"), 149);  // it did not run to the end at once
  EXPECT_EQ(space.at("paused"), space.at("played"));
  EXPECT_EQ(space.at("pointed"), 70);
  EXPECT_EQ(space.at("stepped"), 71);
  EXPECT_EQ(space.at("blank").at("away"), json({{"playing", false}, {"stays", false}}));
  EXPECT_EQ(space["blank"].at("there"), json({{"playing", true}, {"stays", true}}));
  EXPECT_EQ(space.at("address"), "#scene=cube_cuboid&object=cuboid&t=2.37&show=single_frame_obb%2Crotbbox");
  const json& linked = space.at("linked");
  EXPECT_EQ(linked.at("scene"), "skateboard_ball");
  EXPECT_EQ(linked.at("object"), "ball");
  EXPECT_EQ(linked.at("index"), 60);
  EXPECT_EQ(linked.at("variants"), json({"rotbbox"}));
  EXPECT_NEAR(linked.at("mark_s"), 2, 1e-6);
}

void expect_links_show_their_variant(const json& space) {
  const json& weakest = space.at("weakest");
  EXPECT_EQ(weakest.at("variants"), json({"single_frame_obb"}));
  EXPECT_EQ(weakest.at("playing"), false);
  EXPECT_EQ(weakest.at("off_s"), 0);
  EXPECT_EQ(weakest.at("named"), true);
  EXPECT_EQ(weakest.at("iou"), weakest.at("least"));
  EXPECT_EQ(space.at("of_film"), json({{"variants", {"single_frame_obb"}}, {"playing", false}}));
}

}  // namespace uniquadric
