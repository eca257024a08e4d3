#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// A classical segmenter for real images without a learnt model. All numbers are ours, tried on an RGB-D
/// recording of a cabinet.
struct GrabcutOptions {
  int iterations = 3;  // of GrabCut; more change no pixel to speak of
  int downscale = 2;   // GrabCut's image is this much smaller: four times the speed
  static constexpr double context =
      0.2;  // width of the ring around the box that shows the background, share of its side
  static constexpr double depth_reach =
      1.0;  // depth off the box's median by more than this share of its size is background
  static constexpr double plane_threshold_m =
      0.025;                  // most that points of the ring's planes (floor, wall) are off; what lies
                              // on these, within the points' own spread, is cut out of the box
  double plane_share = 0.15;  // of the ring's pixels that a plane needs
  double rim = 0.05;  // width of the object's rim that colour decides, share of the box's shorter side
  static constexpr double depth_jump = 0.03;  // relative jump between neighbours that separates two bodies
};

/// The object in a box: depth far from the box's median is background, and what lies on a plane seen around
/// the box and faces as that does. GrabCut (Rother et al., SIGGRAPH 2004) decides the rest by colour, and the
/// largest part without a jump in depth is kept, its holes filled. `rgb` CV_8UC3, `depth` CV_32FC1 [m, 0
/// none]; returns CV_8UC1 of their size, 255 on the object, all 0 where the box has no depth.
cv::Mat grabcut_depth(const cv::Mat& rgb, const cv::Mat& depth, const Camera& camera, const BoxPrompt& box,
                      const GrabcutOptions& options, RandomStream& random);

}  // namespace uniquadric
