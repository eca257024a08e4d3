#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/camera.h"
#include "estimator/images/support_planes.h"
#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// How depth is cut into parts that stand clear of floor and walls. All numbers are ours.
struct DepthPartsOptions {
  static constexpr double plane_threshold_m =
      0.03;  // most that a plane's points are off at 1 m and nearer; grows with depth
  double plane_share =
      0.1;  // of the image that a plane needs to be floor or wall: a near body's face has less
  static constexpr int max_planes = 6;  // floor, walls, ceiling
  double jump = 0.02;                   // relative, between neighbours that belong to two bodies
  double max_extent_m = 1.5;            // of a body across the image; wider parts are the room
  int min_pixels = 300;                 // smaller parts are noise
};

/// The parts of a depth image (CV_32FC1 [m], 0 none): pixels off its large planes, connected without a jump
/// in depth. CV_16UC1 labels from 1, the largest part first; 0 is all else.
cv::Mat depth_parts(const cv::Mat& depth, const Camera& camera, const DepthPartsOptions& options,
                    RandomStream& random);

/// The label (CV_16UC1, 0 none) that a point lies on, or the nearest within a few pixels of it.
int label_near(const cv::Mat& labels, const PointPrompt& point);

/// The parts that points lie on (or within a few pixels of), CV_16UC1 by the points' ids: what a user meant.
cv::Mat parts_at_points(const cv::Mat& parts, const std::vector<PointPrompt>& points);

}  // namespace uniquadric
