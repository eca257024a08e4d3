#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/images/rigid_motion.h"

namespace uniquadric {

/// An image and its depth (CV_32FC1 [m], 0 none).
struct RgbdImage {
  cv::Mat rgb, depth;
};

struct MovedPixel {
  cv::Point pixel;
  PointSighting sighting;  ///< where it is now in the camera's frame, and where it was seen before
};

inline constexpr int kLeastMovedPixels = 30;  ///< ours: fewer say nothing of a motion

/// An earlier image, and where the pixels of a later one were in it: dense flow at full size (dense_flow.h),
/// for nothing mends its errors here.
struct EarlierImage : RgbdImage {
  cv::Mat flow;
};
EarlierImage with_flow(const RgbdImage& before, const RgbdImage& now);

/// About `samples` pixels of a mask (CV_8UC1 of the box's size) that have depth at both times, and where the
/// flow says that they were. `camera` is without distortion.
std::vector<MovedPixel> moved_pixels(const cv::Mat& mask, const cv::Rect& box, const RgbdImage& now,
                                     const EarlierImage& before, const Camera& camera, int samples);

/// How far from where it was seen a motion puts a pixel [px].
double error_px(const MovedPixel& moved, const Camera& camera, const Pose& motion);

}  // namespace uniquadric
