#include "estimator/segmentation/moving_parts.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>

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

View moved(const Eigen::Vector3d& box_m, int camera_frames, double noise = 0) {
  View view;
  view.box.center += box_m;
  view.camera = scene_camera(camera_frames);
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

// Other greys where a mask is: depth alone decides.
void repaint(FrameImages& images, const cv::Mat& mask) {
  cv::Mat other = images.gray.clone();
  cv::bitwise_xor(other, 128, other, mask);
  images.gray = other;
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

// 3 % of depth: what noise frees is no motion, whatever colour it has. A box that went by its own size moved
// all the same.
TEST(MovingParts, NoiseDoesNotMove) {
  const double noise = 0.03;
  const Seen now = seen(moved({0, 0, 0}, 0, noise), 0);
  std::vector<EarlierImages> rest, away;
  for (int i = 1; i <= 6; ++i) {
    const Seen still = seen(moved({0, 0, 0}, 3 * i, noise), i),
               gone = seen(moved({-0.5, 0.3, 0}, 3 * i, noise), i);
    rest.push_back({still, still.camera.inverse() * now.camera});
    repaint(rest.back(), still.parts != 0);
    away.push_back({gone, gone.camera.inverse() * now.camera});
  }
  EXPECT_EQ(cv::countNonZero(moving_parts(now.parts, now, rest, {}, kCamera, kRatio)), 0);
  EXPECT_GT(cv::countNonZero(moving_parts(now.parts, now, away, {}, kCamera, kRatio)), 0);
}

// A narrow part at the box's upper edge, by a motion that is off by two pixels: behind the edge lies the
// floor.
TEST(MovingParts, AnErrorOfTheMotionFreesNoEdge) {
  const Seen now = seen({}, 0);
  Seen before = seen({}, 1);
  constexpr int kHeight_px = 5;
  cv::Mat strip = now.parts.clone();
  for (int v = kHeight_px; v < strip.rows; ++v) strip.row(v).setTo(0, now.parts.row(v - kHeight_px) != 0);
  ASSERT_GT(cv::countNonZero(strip), 300);
  cv::Mat about;
  cv::dilate(strip, about, cv::Mat::ones(9, 9, CV_8UC1));
  repaint(before, about != 0);
  const auto count = [&](double shift_px) {
    const Pose off{exp_so3({shift_px / kCamera.fy, 0, 0}), Eigen::Vector3d::Zero()};
    const std::vector<EarlierImages> earlier(2, {before, off});
    return cv::countNonZero(moving_parts(strip, now, earlier, {}, kCamera, kRatio));
  };
  for (const double shift_px : {-2, -1, 1, 2}) EXPECT_EQ(count(shift_px), 0) << shift_px;
  before.depth = seen(moved({-0.5, 0.3, 0}, 0), 1).depth;
  EXPECT_GT(count(0), 0);
}

// Hidden pixels are not among those of which a fifth has to be free, but half of all have to be seen.
TEST(MovingParts, WhatIsHiddenDoesNotCount) {
  const Seen now = seen({}, 0);
  const auto count = [&](double hidden, double free) {
    const cv::Rect box = cv::boundingRect(now.parts != 0);
    Seen before = now;
    repaint(before, now.parts != 0);
    before.depth = now.depth.clone();
    for (int v = box.y; v < box.br().y; ++v)
      for (int u = 0; u < box.width; ++u) {
        const cv::Point at(box.x + u, v);
        if (now.parts.at<std::uint16_t>(at) == 0) continue;
        if (u < hidden * box.width) before.depth.at<float>(at) *= 0.5F;
        if (u >= (1 - free) * box.width) before.depth.at<float>(at) *= 2;
      }
    const std::vector<EarlierImages> earlier(2, {before, Pose{}});
    return cv::countNonZero(moving_parts(now.parts, now, earlier, {}, kCamera, kRatio));
  };
  EXPECT_EQ(count(0, 0.15), 0);
  EXPECT_EQ(count(0, 0.45), box_pixels());
  EXPECT_EQ(count(0.4, 0.26), box_pixels());
  EXPECT_EQ(count(0.7, 0.25), 0);
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
  const Seen now = seen({}, 0), before = seen(moved({-0.5, 0.3, 0}, 0), 1);
  const auto count = [&](FrameImages at, FrameImages earlier, const char* blind) {
    const cv::Mat none = cv::Mat::zeros(now.depth.size(), CV_32FC1);
    if (blind == std::string("now")) at.depth = none;
    if (blind == std::string("before")) earlier.depth = none;
    const std::vector<EarlierImages> both(2, {earlier, Pose{}});
    return cv::countNonZero(moving_parts(now.parts, at, both, {}, kCamera, kRatio));
  };
  EXPECT_EQ(count(now, before, "neither"), box_pixels());
  EXPECT_EQ(count(now, before, "now"), 0);
  EXPECT_EQ(count(now, before, "before"), 0);
  EXPECT_EQ(cv::countNonZero(moving_parts(now.parts, now, {}, {}, kCamera, kRatio)), 0);
}

}  // namespace
}  // namespace uniquadric
