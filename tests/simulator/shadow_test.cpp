// Shadows, highlights and what a depth sensor gets back.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "simulator/render/renderer.h"
#include "tests/simulator/simple_scene.h"

namespace uniquadric {
namespace {

constexpr double kAmbient = 0.2, kScale_px = 100;  // of a metre on the ground, seen from 5 m above

Mesh white(const Eigen::Vector3d& axes) {
  Mesh mesh = box_mesh(axes);
  mesh.texture = cv::Mat();
  return mesh;
}

Body white_box(int id, const Eigen::Vector3d& axes, const Eigen::Vector3d& centre) {
  return make_body(id, white(axes), axes, fixed({Eigen::Quaterniond::Identity(), centre}));
}

// A white ground at z = 0 seen from straight above: x to the right, y up in the image.
Scene ground() {
  Scene scene;
  scene.camera = {320, 240, 500, 500, 159.5, 119.5, {}};
  scene.camera_motion =
      fixed({Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitX())), {0, 0, 5}});
  scene.ambient = kAmbient;
  scene.shadows = true;
  scene.sun_direction = {1, 0, -1};
  scene.world = {white_box(0, {3, 3, 0.1}, {0, 0, -0.1})};
  return scene;
}

cv::Mat draw(const Scene& scene) {
  return Renderer(scene).render(poses_at(scene, 0)).rgba.clone();
}

int at(const cv::Mat& rgba, double x_m, double y_m) {
  return rgba.at<cv::Vec4b>(static_cast<int>(std::lround(119.5 - kScale_px * y_m)),
                            static_cast<int>(std::lround(159.5 + kScale_px * x_m)))[0];
}

int level(double sun_cosine) {
  return static_cast<int>(std::lround(255 * (kAmbient + (1 - kAmbient) * sun_cosine)));
}
const int kShade = level(0), kSunny = level(std::sqrt(0.5));

// Where a row is dark, first and last, to the right of from_m.
struct Span {
  double from_m = 0, to_m = 0;
};
Span dark_span(const cv::Mat& rgba, double y_m, double from_m, int sunny = kSunny) {
  Span span{1e9, -1e9};
  const int middle = (kShade + sunny) / 2;
  for (double x_m = from_m; x_m < 1.59; x_m += 1 / kScale_px)
    if (at(rgba, x_m, y_m) < middle) span = {std::min(span.from_m, x_m), std::max(span.to_m, x_m)};
  return span;
}

TEST(Shadows, EndWhereTheSunPassesTheBoxesEdges) {
  constexpr double kTolerance_m = 2 / kScale_px;  // two pixels
  for (const bool moves : {false, true}) {
    Scene scene = ground();  // a sun at 45 degrees: the shadow is as long as the box is high, 0.4 m
    (moves ? scene.objects : scene.world).push_back(white_box(moves, {0.2, 0.3, 0.2}, {0, 0, 0.2}));
    const cv::Mat rgba = draw(scene);
    EXPECT_NEAR(dark_span(rgba, 0, 0.25).to_m, 0.6, kTolerance_m) << moves;
    EXPECT_EQ(at(rgba, 0.45, 0), kShade) << moves;
    EXPECT_EQ(at(rgba, 0.45, 0.27), kShade) << moves;
    EXPECT_EQ(at(rgba, 0.45, 0.33), kSunny) << moves;
    EXPECT_EQ(at(rgba, 0.45, -0.33), kSunny) << moves;
    EXPECT_EQ(at(rgba, 0.65, 0), kSunny) << moves;
    EXPECT_EQ(at(rgba, -0.4, 0), kSunny) << moves;
    EXPECT_EQ(at(rgba, 0, 0), kSunny) << "the top shadows itself, moves: " << moves;
  }
}

TEST(Shadows, TouchWhatCastsThem) {
  Scene scene = ground();  // 1 cm thin
  scene.objects = {white_box(1, {0.3, 0.3, 0.005}, {0, 0, 0.005})};
  scene.sun_direction = {1, 0, -0.1};  // grazing: ten times as long
  const cv::Mat rgba = draw(scene);
  const Span span = dark_span(rgba, 0, 0.305, level(0.1 / std::hypot(1, 0.1)));
  EXPECT_NEAR(span.from_m, 0.31, 0.01);  // there is no gap
  EXPECT_NEAR(span.to_m, 0.4, 0.02);
}

TEST(Shadows, FallOnObjectsAndMoveWithThem) {
  Scene scene = ground();
  scene.objects = {white_box(1, {0.1, 0.3, 0.1}, {0, 0, 0.9}), white_box(2, {0.2, 0.3, 0.1}, {0.7, 0, 0.1})};
  Renderer renderer(scene);
  ScenePoses poses = poses_at(scene, 0);
  EXPECT_EQ(at(renderer.render(poses).rgba, 0.72, 0), kShade);  // nearer to the camera by 4 %
  poses.world_from_object[0].translation.x() -= 0.9;
  const cv::Mat moved = renderer.render(poses).rgba;
  EXPECT_EQ(at(moved, 0.72, 0), kSunny);
  EXPECT_EQ(at(moved, 0, 0), kShade);
}

TEST(Shadows, FallOnNothingUnlessAskedFor) {
  Scene scene = ground();
  scene.shadows = false;
  scene.objects = {white_box(1, {0.2, 0.3, 0.2}, {0, 0, 0.2})};
  EXPECT_EQ(at(draw(scene), 0.45, 0), kSunny);
}

TEST(Shadows, AreThoseOfEachStepsPoses) {
  Scene scene = ground();
  scene.objects = {white_box(1, {0.2, 0.3, 0.2}, {0, 0, 0.2})};
  scene.imaging.exposure_s = 0.01;
  ScenePoses here = poses_at(scene, 0), away = here;
  away.world_from_object[0].translation.x() = -1;
  const cv::Mat rgba = Renderer(scene).render(here, {ColorStep{here, {}}, ColorStep{away, {}}}).rgba;
  EXPECT_NEAR(at(rgba, 0.45, 0), (kShade + kSunny) / 2.0, 1);
}

TEST(Shadows, LetTheSunThroughSurfacesSeenFromInside) {
  Scene scene = ground();  // a room, its faces turned inwards, about camera and ground
  Mesh room = white({2.5, 2.5, 4});
  for (auto& triangle : room.triangles) std::swap(triangle[1], triangle[2]);
  for (auto& normal : room.normals) normal = -normal;
  scene.world = {make_body(0, room, {2.5, 2.5, 4}, fixed({Eigen::Quaterniond::Identity(), {0, 0, 4}}))};
  const cv::Mat rgba = draw(scene);
  for (const double x_m : {-1.5, -0.5, 0.5, 1.5}) EXPECT_EQ(at(rgba, x_m, 0.5), kSunny) << x_m;
}

TEST(Highlights, StandWhereTheGroundMirrorsTheSun) {
  Scene scene = ground();  // sun and camera stand 0.5 m apart on either side of the mirror's point
  scene.shadows = false;
  scene.sun_direction = Eigen::Vector3d(-0.5, 0, -5).normalized();
  Mesh& mesh = scene.world[0].meshes[0];
  mesh.color = Eigen::Vector3f::Constant(0.2f);
  mesh.shine = 0.5f;
  mesh.depth_return = 0.8f;
  const cv::Mat rgba = draw(scene);
  const double dull = 0.2 * (kAmbient + (1 - kAmbient) * 5 / std::hypot(5, 0.5));
  const cv::Vec4b mirror = rgba.at<cv::Vec4b>(119, 209), side = rgba.at<cv::Vec4b>(119, 109);
  EXPECT_NEAR(mirror[0], 255 * (dull + 0.5), 1);
  EXPECT_NEAR(mirror[3], 255 * 0.8 * 0.5, 1);
  // 0.5 m on the other side the halfway vector is off by half of twice the angle.
  const double strength = 0.5 * std::pow(std::cos(std::atan(0.1)), 32);
  EXPECT_NEAR(side[0], 255 * (dull + strength), 1.5);
  EXPECT_NEAR(side[3], 255 * 0.8 * (1 - strength), 1.5);
}

TEST(Highlights, AreNoneInShadow) {
  Scene scene = ground();
  scene.sun_direction = Eigen::Vector3d(-0.5, 0, -5).normalized();
  scene.world[0].meshes[0].shine = 1;
  scene.world[0].meshes[0].depth_return = 0.8f;
  scene.objects = {white_box(1, {0.1, 0.1, 0.1}, {0.5 + 0.8, 0, 8})};  // above the camera
  const cv::Vec4b pixel = draw(scene).at<cv::Vec4b>(119, 209);
  for (int channel = 0; channel < 3; ++channel) EXPECT_EQ(pixel[channel], kShade);
  EXPECT_EQ(pixel[3], 204);  // of 255, 0.8
}

TEST(DepthReturn, IsOfSurfacesOwnColourInSunAndShadow) {
  Scene scene = ground();
  scene.objects = {white_box(1, {0.2, 0.3, 0.2}, {0, 0, 0.2})};
  scene.objects[0].meshes[0].depth_return = 0.4f;
  scene.imaging.gain = 0.5;
  scene.depth_noise.delay_s = 0.1;
  Mesh& floor = scene.world[0].meshes[0];
  floor.color = Eigen::Vector3f::Constant(0.6f);
  for (const bool lens : {false, true}) {
    if (lens) scene.camera.distortion = {0.01, 0, 0, 0, 0};
    Renderer renderer(scene);
    const ScenePoses poses = poses_at(scene, 0);
    const cv::Mat& rgba = renderer.render(poses).rgba;
    ASSERT_LT(at(rgba, 0.45, 0), at(rgba, -0.45, 0));
    const RenderedFrame& returned = renderer.returned(poses);
    for (const double x_m : {-0.45, 0.45}) EXPECT_EQ(at(returned.rgba, x_m, 0), std::lround(255 * 0.6f));
    EXPECT_EQ(at(returned.rgba, 0, 0), 255);
    EXPECT_EQ(cv::countNonZero(returned.depth_m != renderer.depth_m(poses)), 0);
  }
}

TEST(DepthReturn, IsTheFourthChannel) {
  Scene scene = white_square();
  for (const float share : {0.0f, 0.4f, 1.0f}) {
    scene.objects[0].meshes[0].depth_return = share;
    const cv::Mat rgba = Renderer(scene).render(shifted(0, 0)).rgba;
    EXPECT_EQ(rgba.at<cv::Vec4b>(40, 50)[0], 255);
    EXPECT_EQ(rgba.at<cv::Vec4b>(40, 50)[3], std::lround(255 * share));
    EXPECT_EQ(rgba.at<cv::Vec4b>(2, 2)[3], 0);
  }
}

}  // namespace
}  // namespace uniquadric
