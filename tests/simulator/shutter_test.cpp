// Colour over the time of an exposure and of a rolling shutter.
#include <gtest/gtest.h>

#include <algorithm>

#include "simulator/render/renderer.h"
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
    exposure.push_back({shifted(kWidth_px * ((i + 0.5) / kSteps - 0.5), 0), 0, scene.camera.height});
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
double time_of(const ColorStep& step) {
  return (step.poses.world_from_object.at(1).translation.x() + 0.6) / 1.2;
}

TEST(ColorSteps, AreTheMiddlesOfTheExposureAboutTheStamp) {
  Scene scene = two_boxes();
  EXPECT_TRUE(color_steps(scene, 0.5).empty());
  scene.imaging.exposure_s = 0.03;
  scene.imaging.exposure_steps = 3;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(time_of(steps[i]), 0.49 + 0.01 * i, 1e-12);
    EXPECT_EQ(steps[i].first_row, 0);
    EXPECT_EQ(steps[i].rows, scene.camera.height);
  }
}

TEST(ColorSteps, RollDownTheRowsAboutTheStamp) {
  Scene scene = two_boxes();
  scene.imaging.rolling_shutter_s = 0.03;
  scene.imaging.rolling_shutter_bands = 7;  // does not divide the 120 rows
  scene.imaging.exposure_s = 0.01;
  scene.imaging.exposure_steps = 2;
  const auto steps = color_steps(scene, 0.5);
  ASSERT_EQ(steps.size(), 14u);
  int next_row = 0;
  for (std::size_t i = 0; i < steps.size(); i += 2) {
    EXPECT_EQ(steps[i].first_row, next_row);
    EXPECT_EQ(steps[i + 1].first_row, next_row);
    EXPECT_EQ(steps[i + 1].rows, steps[i].rows);
    const double middle_row = next_row + steps[i].rows / 2.0;
    EXPECT_NEAR((time_of(steps[i]) + time_of(steps[i + 1])) / 2, 0.5 + 0.03 * (middle_row / 120 - 0.5),
                1e-12);
    EXPECT_NEAR(time_of(steps[i + 1]) - time_of(steps[i]), 0.005, 1e-12);
    next_row += steps[i].rows;
  }
  EXPECT_EQ(next_row, 120);
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
  scene.imaging.rolling_shutter_bands = height;  // each row at its own time
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
    scene.imaging.rolling_shutter_bands = 9;
    const RenderedFrame rolling = Renderer(scene).render(poses_at(scene, 1), color_steps(scene, 1));
    EXPECT_TRUE(same(at_once.rgba, rolling.rgba)) << samples;
    EXPECT_TRUE(same(at_once.ids, rolling.ids)) << samples;
  }
}

// What is hidden is found before colour is made, in bands that cut through the bodies; some of them shine.
TEST(Renderer, ExposuresOfBodiesBehindEachOtherHaveTheColorsOfOneImage) {
  Scene scene = two_boxes();
  scene.imaging.samples = 1;
  scene.shadows = true;
  scene.objects[1].meshes[0].shine = 0.6f;
  const ScenePoses poses = poses_at(scene, 0.4);
  const RenderedFrame at_once = Renderer(scene).render(poses);
  scene.imaging.exposure_s = 0.01;  // the renderer prepares for steps
  const int half = scene.camera.height / 2;
  const std::vector<ColorStep> steps = {
      {poses, 0, half}, {poses, 0, half}, {poses, half, half}, {poses, half, half}};
  const RenderedFrame exposed = Renderer(scene).render(poses, steps);
  EXPECT_TRUE(same(at_once.rgba, exposed.rgba));
}

}  // namespace
}  // namespace uniquadric
