#include "estimator/segmentation/grabcut_depth.h"

#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "box_scene.h"
#include "drawn_world.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

const Camera kCamera{320, 240, 260, 260, 159.5, 119.5, {}};

// Least upright box around a mask, widened by 3 px as a detector's.
BoxPrompt box_around(const cv::Mat& mask) {
  const cv::Rect box = id_boxes(mask).at(1);
  return {1, box.x - 3.0, box.y - 3.0, box.width + 6.0, box.height + 6.0};
}

TEST(GrabcutDepth, CutsABoxOffTheFloorItStandsOn) {
  int cases = 0;
  for (int i = 0; i < 3; ++i) {
    RandomStream random(1, "image", i);
    const BoxImage image = render_box(kCamera, scene_camera(5 * i), scene_box(5 * i), random);
    cv::Mat depth;
    image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
    const cv::Mat mask =
        grabcut_depth(image.rgb, depth, kCamera, box_around(image.mask), GrabcutOptions{}, random);
    EXPECT_GT(mask_iou(mask, image.mask == 1), 0.93) << i;  // its foot included
    EXPECT_LT(cv::countNonZero(mask & (image.mask == 0)), cv::countNonZero(mask) / 50) << i;
    ++cases;
  }
  EXPECT_EQ(cases, 3);
}

// A cube of 85 mm on a table, from 10 cm above it, between two flat things: no plane about it is tight, and
// its foot is within what counts as on it.
TEST(GrabcutDepth, KeepsTheFootOfWhatStandsOnAClutteredTable) {
  RandomStream random(4, "image");
  const Pose camera = look_at({0, -0.47, 0.12}, {0, 0, 0.04});
  const auto box = [](double x, double y, const Eigen::Vector3d& half_m) {
    return OrientedBox{{x, y, half_m.z()}, Eigen::Matrix3d::Identity(), half_m};
  };
  const BoxImage cube = render_box(kCamera, camera, box(0, 0, {0.0425, 0.0425, 0.0425}), random);
  cv::Mat depth = cube.depth.clone(), cube_mask = cube.mask == 1;
  for (const double side : {-1.0, 1.0}) {
    const BoxImage flat = render_box(kCamera, camera, box(0.12 * side, 0.02, {0.05, 0.1, 0.012}), random);
    const cv::Mat is_before = (flat.depth > 0) & (flat.depth < depth);
    flat.depth.copyTo(depth, is_before);
    cube_mask.setTo(0, is_before);
  }
  depth.convertTo(depth, CV_32F, 1 / 5000.0);
  const cv::Mat mask = grabcut_depth(cube.rgb, depth, kCamera, box_around(cube.mask), {}, random);
  EXPECT_GT(mask_iou(mask, cube_mask), 0.85);
}

TEST(GrabcutDepth, DepthDecidesWhereColourCannot) {
  RandomStream random(2, "image");
  const BoxImage image = render_box(kCamera, scene_camera(0), scene_box(0), random);
  const cv::Mat grey(image.rgb.size(), CV_8UC3, cv::Scalar(128, 128, 128));
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
  const cv::Mat mask = grabcut_depth(grey, depth, kCamera, box_around(image.mask), GrabcutOptions{}, random);
  EXPECT_GT(mask_iou(mask, image.mask == 1), 0.7);  // its rim of a twentieth on each side may go to the floor
}

TEST(GrabcutDepth, ABoxWithoutDepthHasNoMask) {
  RandomStream random(3, "image");
  const cv::Mat rgb(240, 320, CV_8UC3, cv::Scalar(9, 9, 9)), depth = cv::Mat::zeros(240, 320, CV_32FC1);
  EXPECT_EQ(cv::countNonZero(grabcut_depth(rgb, depth, kCamera, {1, 50, 50, 60, 60}, {}, random)), 0);
}

// Numbers that no int holds mean the same as a box that merely covers the whole image.
TEST(GrabcutDepth, ABoxBeyondAllNumbersIsTheWholeImage) {
  RandomStream random(5, "image");
  const BoxImage image = render_box(kCamera, scene_camera(0), scene_box(0), random);
  cv::Mat depth;
  image.depth.convertTo(depth, CV_32F, 1 / 5000.0);
  const auto mask_of = [&](const BoxPrompt& box) {
    RandomStream own(6, "grabcut");
    return grabcut_depth(image.rgb, depth, kCamera, box, {}, own);
  };
  const cv::Mat whole = mask_of({1, -1e6, -1e6, 2e6, 2e6});
  EXPECT_GT(cv::countNonZero(whole), kCamera.width * kCamera.height / 2);
  int boxes = 0;
  for (const auto& [low, size] : {std::pair(-1e300, 2e300), std::pair(-8e307, 1.6e308)}) {
    EXPECT_EQ(cv::countNonZero(mask_of({1, low, low, size, size}) != whole), 0) << low;
    ++boxes;
  }
  EXPECT_EQ(boxes, 2);
}

}  // namespace
}  // namespace uniquadric
