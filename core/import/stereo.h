#pragma once

#include <memory>
#include <opencv2/core/mat.hpp>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// Two cameras whose images are rectified onto common rows, for depth of the left one.
class StereoRig {
 public:
  StereoRig(const Camera& left, const Camera& right, const Pose& right_from_left);
  StereoRig(StereoRig&&) noexcept;
  ~StereoRig();
  /// The rectified left camera: no distortion, and its place.
  const Camera& camera() const { return camera_; }
  const Pose& rectified_from_left() const { return rectified_from_left_; }
  /// The left camera's image as the rectified one sees it.
  cv::Mat rectify_left(const cv::Mat& image) const;
  /// Depth of the rectified camera by semi-global matching of two 8-bit images, 16UC1 with `units_per_m`; 0
  /// where there is none.
  cv::Mat depth(const cv::Mat& left, const cv::Mat& right, double units_per_m) const;

 private:
  struct Maps;
  std::unique_ptr<const Maps> maps_;
  Camera camera_;
  Pose rectified_from_left_;
  double bf_ = 0;  // px m
};

}  // namespace uniquadric
