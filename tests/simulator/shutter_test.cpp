// Colour over the time of an exposure and of a rolling shutter.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <memory>

#include "simulator/render/renderer.h"
#include "simulator/render/short_edges.h"
#include "simulator/scene/curve.h"
#include "simulator/scene/named_motions.h"
#include "tests/simulator/same_image.h"
#include "tests/simulator/simple_scene.h"

namespace uniquadric {
namespace {

TEST(Renderer, ExposureIsTheMeanOverTheTimeTheShutterIsOpen) {
  // An edge that sweeps w pixels leaves a ramp w pixels wide; ids are those of its middle.
  Scene scene = white_square();
  scene.imaging.samples = 1;
  scene.imaging.exposure_s = 0.01;
  Renderer renderer(scene);
  constexpr int kSteps = 40, kWidth_px = 10;
  std::vector<ColorStep> exposure;
  for (int i = 0; i < kSteps; ++i)
    exposure.push_back({shifted(kWidth_px * ((i + 0.5) / kSteps - 0.5), 0), {}});
  const RenderedFrame& frame = renderer.render(shifted(0, 0), exposure);
  int ramp = 0;
  for (int u = 20; u < 45; ++u) {  // the edge's middle stands between columns 29 and 30
    const double share = std::clamp((u + 0.5 - (30 - kWidth_px / 2)) / kWidth_px, 0.0, 1.0);
    EXPECT_NEAR(frame.rgba.at<cv::Vec4b>(40, u)[0], 255 * share, 255.0 / kSteps) << u;
    ramp += share > 0 && share < 1;
    EXPECT_EQ(frame.ids.at<std::uint16_t>(40, u), u >= 30 ? 1 : 0);
  }
  EXPECT_EQ(ramp, kWidth_px);
}

// Where the second of two_boxes() is: a clock, at 1.2 m/s from -0.6 m on.
double time_of(const ScenePoses& poses) {
  return (poses.world_from_object.at(1).translation.x() + 0.6) / 1.2;
}

TEST(ColorSteps, AreTheMiddlesOfTheExposureAboutTheStamp) {
  Scene scene = two_boxes();
  EXPECT_TRUE(color_steps(scene, 0.5).empty());
  scene.imaging.exposure_s = 0.03;
  scene.imaging.exposure_steps = 3;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(time_of(steps[i].poses), 0.49 + 0.01 * i, 1e-12);
    EXPECT_FALSE(steps[i].edges);
  }
}

TEST(ColorSteps, RollDownTheRowsAboutTheStamp) {
  Scene scene = two_boxes();
  scene.imaging.rolling_shutter_s = 0.03;
  scene.imaging.exposure_s = 0.01;
  scene.imaging.exposure_steps = 2;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 2u);
  for (int i = 0; i < 2; ++i) {
    const double middle_s = 0.4975 + 0.005 * i;
    EXPECT_NEAR(time_of(steps[i].poses), middle_s, 1e-12);
    EXPECT_NEAR(time_of(steps[i].edges.value()[0]), middle_s - 0.015, 1e-12);
    EXPECT_NEAR(time_of(steps[i].edges.value()[1]), middle_s + 0.015, 1e-12);
  }
}

// A motion along x at a constant speed [m/s] that passes shifted(0, 0) at 1 s.
Motion across(double speed_mps) {
  return line_motion({Eigen::Quaterniond::Identity(), {-speed_mps, 0, 1.01}}, {speed_mps, 0, 0});
}

TEST(Renderer, RollingShutterLeansAMovingEdgeByItsSpeedTimesTheRowsDelay) {
  constexpr double kSpeed_pxps = 400, kReadout_s = 0.02;  // 8 px from the first row to the last
  Scene scene = white_square();
  scene.objects[0].motion = across(kSpeed_pxps / 100);
  const int height = scene.camera.height;
  scene.imaging.rolling_shutter_s = kReadout_s;
  Renderer renderer(scene);
  const RenderedFrame& frame = renderer.render(poses_at(scene, 1), color_steps(scene, 1));
  constexpr double kSample_px = 0.25;  // an edge is met by four samples a pixel
  int rows = 0;
  for (int v = 22; v < 58; ++v, ++rows) {
    double white_px = 0;  // left of the square's middle, so that the left edge alone counts
    for (int u = 10; u < 50; ++u) white_px += frame.rgba.at<cv::Vec4b>(v, u)[0] / 255.0;
    const double delay_s = kReadout_s * ((v + 0.5) / height - 0.5);
    EXPECT_NEAR(50 - white_px, 30 + kSpeed_pxps * delay_s, kSample_px) << "row " << v;
    for (const int u : {29, 30}) {  // ids and depth stay those of the stamp
      EXPECT_EQ(frame.ids.at<std::uint16_t>(v, u), u < 30 ? 0 : 1);
      EXPECT_EQ(frame.depth_m.at<float>(v, u) > 0, u >= 30);
    }
  }
  EXPECT_EQ(rows, 36);
}

TEST(Renderer, RollingShutterOfAWorldAtRestChangesNothing) {
  for (const int samples : {1, 4}) {
    Scene scene = white_square();
    scene.objects[0].motion = across(0);
    scene.imaging.samples = samples;
    const RenderedFrame at_once = Renderer(scene).render(poses_at(scene, 1));
    scene.imaging.rolling_shutter_s = 0.02;
    const RenderedFrame rolling = Renderer(scene).render(poses_at(scene, 1), color_steps(scene, 1));
    EXPECT_TRUE(same(at_once.rgba, rolling.rgba)) << samples;
    EXPECT_TRUE(same(at_once.ids, rolling.ids)) << samples;
  }
}

class CarriedCurve : public Motion::Curve {
 public:
  Kinematics kinematics(double time_s) const override {
    return shifting({0.8, -0.3, 0.6}, {time_s, 1, 0}) * turning({0.3, 0.8, -0.5}, {time_s, 1, 0});
  }
};

// A camera that is carried about between walls that reach behind it; a box turns before it.
Scene carried_about() {
  Scene scene = two_boxes();
  const Eigen::Vector3d floor(4, 0.05, 4);
  scene.world.push_back(make_body(0, box_mesh(floor), floor, fixed({exp_so3({0, 0, 0}), {0.3, 1, 1}})));
  const Eigen::Vector3d wall(0.05, 4, 4);
  scene.world.push_back(make_body(0, box_mesh(wall), wall, fixed({exp_so3({0, 0, 0}), {-1.2, 0, 1}})));
  scene.camera_motion = Motion(std::make_shared<CarriedCurve>());
  return scene;
}

// The second way draws a whole image for each row.
TEST(Renderer, RollingShutterDrawsEachRowAtItsOwnTime) {
  using Distortion = std::array<double, 5>;
  constexpr double kReadout_s = 0.03, kTime_s = 0.4;
  for (const Distortion& distortion :
       {Distortion{}, {-0.15, 0.08, 0.002, -0.002, 0}, {0.2, -0.15, 0, 0, 0}}) {
    Scene scene = carried_about();
    scene.camera.distortion = distortion;
    Renderer at_once(scene);
    scene.imaging.rolling_shutter_s = kReadout_s;
    const cv::Mat rolled = Renderer(scene).render(poses_at(scene, kTime_s), color_steps(scene, kTime_s)).rgba;
    cv::Mat rows(rolled.size(), rolled.type()), middle, difference;
    for (int v = 0; v < rows.rows; ++v) {
      const double time_s = kTime_s + kReadout_s * ((v + 0.5) / rows.rows - 0.5);
      at_once.render(poses_at(scene, time_s)).rgba.row(v).copyTo(rows.row(v));
    }
    at_once.render(poses_at(scene, kTime_s)).rgba.copyTo(middle);
    const auto mean_difference = [&](const cv::Mat& image) {
      cv::absdiff(image, rows, difference);
      return cv::mean(difference)[0];
    };
    EXPECT_LT(mean_difference(rolled), 0.05 * mean_difference(middle));
    EXPECT_GT(mean_difference(middle), 3);
  }
}

TEST(ShortEdges, KeepASurfaceWhole) {
  const Mesh box = box_mesh({1, 0.5, 0.25});
  const std::vector<Eigen::Vector3f> cameras_m = {{1.5f, 0, 0}, {0, 0.9f, 0.1f}};
  const Mesh cut = with_short_edges(box, cameras_m);
  const auto nearest = [&](const Eigen::Vector3f& p) {
    return std::min((p - cameras_m[0]).norm(), (p - cameras_m[1]).norm());
  };
  double area_m2 = 0;
  std::map<std::array<float, 6>, int> sides;  // an edge as it is run through
  for (const auto& t : cut.triangles) {
    const auto corner = [&](int k) { return cut.positions[t[k % 3]]; };
    const Eigen::Vector3f across = (corner(1) - corner(0)).cross(corner(2) - corner(0));
    area_m2 += 0.5 * across.norm();
    EXPECT_GT(across.dot(cut.normals[t[0]]), 0);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f a = corner(k), b = corner(k + 1);
      EXPECT_LE((b - a).norm(), std::max(0.05f, 0.5f * nearest(0.5f * (a + b))));
      ++sides[{a.x(), a.y(), a.z(), b.x(), b.y(), b.z()}];
    }
  }
  EXPECT_NEAR(area_m2, 2 * (2 * 1 + 2 * 0.5 + 1 * 0.5), 1e-5);
  for (const auto& [side, count] : sides) {  // no gap: the neighbour runs through it the other way
    EXPECT_EQ(count, 1);
    EXPECT_EQ(sides.count({side[3], side[4], side[5], side[0], side[1], side[2]}), 1u);
  }
}

// What is hidden is found before colour is made; some of the bodies shine.
TEST(Renderer, ExposuresOfBodiesBehindEachOtherHaveTheColorsOfOneImage) {
  Scene scene = two_boxes();
  scene.imaging.samples = 1;
  scene.shadows = true;
  scene.objects[1].meshes[0].shine = 0.6f;
  const ScenePoses poses = poses_at(scene, 0.4);
  const RenderedFrame at_once = Renderer(scene).render(poses);
  scene.imaging.exposure_s = 0.01;  // the renderer prepares for steps
  const std::vector<ColorStep> steps(2, ColorStep{poses, {}});
  const RenderedFrame exposed = Renderer(scene).render(poses, steps);
  EXPECT_TRUE(same(at_once.rgba, exposed.rgba));
}

}  // namespace
}  // namespace uniquadric
