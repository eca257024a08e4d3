#include "estimator/segmentation/moving_parts.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "box_scene.h"
#include "core/base/random.h"

namespace uniquadric {
namespace {

const Camera kCamera{320, 240, 260, 260, 159.5, 119.5, {}};
constexpr double kRatio = 6;

// A box on a floor, the camera, and the depth's noise (sigma, relative).
struct View {
  OrientedBox box = scene_box(0);
  Pose camera = scene_camera(0);
  double noise = 0;
};

View moved(const Eigen::Vector3d& box_m, double camera_frames, double noise = 0) {
  View view;
  view.box.center += box_m;
  view.camera = scene_camera(static_cast<int>(camera_frames));
  view.noise = noise;
  return view;
}

struct Seen : FrameImages {
  cv::Mat parts;
  Pose camera;
};

Seen seen(const View& view, std::uint64_t seed) {
  RandomStream random(seed, "moving_parts");
  const BoxImage image = render_box(kCamera, view.camera, view.box, random);
  Seen result{{}, image.mask, view.camera};
  cv::cvtColor(image.rgb, result.gray, cv::COLOR_BGR2GRAY);
  image.depth.convertTo(result.depth, CV_32F, 1 / 5000.0);
  for (auto& z_m : cv::Mat_<float>(result.depth)) z_m *= 1 + static_cast<float>(view.noise * random.normal());
  return result;
}

// Pixels that are told to move in the first of the views, against the others.
int moving(const View& now, const std::vector<View>& earlier, const cv::Mat& keeps = {}) {
  const Seen last = seen(now, 0);
  std::vector<EarlierImages> before;
  for (std::size_t i = 0; i < earlier.size(); ++i) {
    const Seen one = seen(earlier[i], i + 1);
    before.push_back({one, one.camera.inverse() * last.camera});
  }
  const cv::Mat result = moving_parts(last.parts, last, before, keeps, kCamera, kRatio);
  EXPECT_EQ(cv::countNonZero((result != 0) & (result != last.parts)), 0);  // whole parts, by their names
  return cv::countNonZero(result);
}

int box_pixels() {
  return cv::countNonZero(seen({}, 0).parts);
}

TEST(MovingParts, AreThoseWhosePlaceWasFree) {
  const Eigen::Vector3d away(-0.08, 0.05, 0);
  EXPECT_EQ(moving({}, {moved(away, 5), moved(2 * away, 10)}), box_pixels());
  EXPECT_EQ(moving({}, {moved({0, 0, 0}, 5), moved({0, 0, 0}, 10)}), 0);  // the camera's motion is none of it
}

TEST(MovingParts, OneEarlierImageMayErr) {
  const View away = moved({-0.1, 0.06, 0}, 5), here = moved({0, 0, 0}, 10);
  EXPECT_EQ(moving({}, {away}), 0);
  EXPECT_EQ(moving({}, {away, here, here}), 0);
  EXPECT_EQ(moving({}, {away, here, away}), box_pixels());
}

// 3 % of depth: what noise frees is no motion. A box that went by its own size moved all the same.
TEST(MovingParts, NoiseDoesNotMove) {
  const double noise = 0.03;
  const View now = moved({0, 0, 0}, 0, noise);
  std::vector<View> rest, away;
  for (int i = 1; i <= 6; ++i) {
    rest.push_back(moved({0, 0, 0}, 3 * i, noise));
    away.push_back(moved({-0.5, 0.3, 0}, 3 * i, noise));
  }
  EXPECT_EQ(moving(now, rest), 0);
  EXPECT_GT(moving(now, away), 0);
}

// What came out from behind the box was hidden before, not free.
TEST(MovingParts, WhatWasHiddenDoesNotMove) {
  const Seen now = seen({}, 0), before = seen(moved({0.15, 0.1, 0}, 0), 1);
  const cv::Mat revealed = (now.parts == 0) & (before.parts != 0);
  ASSERT_GT(cv::countNonZero(revealed), 300);
  cv::Mat parts = cv::Mat::zeros(now.parts.size(), CV_16UC1);
  parts.setTo(4, revealed);
  const std::vector<EarlierImages> earlier(2, {before, Pose{}});
  EXPECT_EQ(cv::countNonZero(moving_parts(parts, now, earlier, {}, kCamera, kRatio)), 0);
}

TEST(MovingParts, WhatIsTrackedStays) {
  const cv::Mat parts = seen({}, 0).parts;
  const View rest;
  EXPECT_EQ(moving({}, {rest, rest}, parts), box_pixels());
  cv::Mat little = parts.clone();
  little.colRange(0, 170).setTo(0);
  ASSERT_LT(2 * cv::countNonZero(little), box_pixels());
  EXPECT_EQ(moving({}, {rest, rest}, little), 0);
}

// A depth of its own makes no body of what looks as the wall behind did.
TEST(MovingParts, WhatLooksAsBeforeDoesNotMove) {
  const Seen now = seen({}, 0);
  Seen before = seen(moved({-0.5, 0.3, 0}, 0), 1);
  const auto count = [&] {
    const std::vector<EarlierImages> earlier(2, {before, Pose{}});
    return cv::countNonZero(moving_parts(now.parts, now, earlier, {}, kCamera, kRatio));
  };
  EXPECT_EQ(count(), box_pixels());
  before.gray = now.gray;
  EXPECT_EQ(count(), 0);
}

TEST(MovingParts, WithoutDepthNothingIsSaid) {
  const Seen now = seen({}, 0);
  FrameImages blind = now;
  blind.depth = cv::Mat::zeros(now.depth.size(), CV_32FC1);
  const auto count = [&](const FrameImages& images, const std::vector<EarlierImages>& earlier) {
    return cv::countNonZero(moving_parts(now.parts, images, earlier, {}, kCamera, kRatio));
  };
  EXPECT_EQ(count(now, {}), 0);
  EXPECT_EQ(count(now, {{blind, Pose{}}, {blind, Pose{}}}), 0);
  EXPECT_EQ(count(blind, {{now, Pose{}}, {now, Pose{}}}), 0);
}

}  // namespace
}  // namespace uniquadric
