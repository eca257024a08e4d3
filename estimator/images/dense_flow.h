#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// Dense inverse-search optical flow (Kroeger et al., ECCV 2016), as OpenCV has it.
struct FlowOptions {
  enum class Preset { ultrafast, fast, medium };
  // ours: masks carried by one frame (occlusion_2, half size): ultrafast 1.3 ms, IoU 0.966; fast 3.7 ms,
  // 0.962; medium 30 ms, 0.971
  Preset preset = Preset::ultrafast;
  int downscale = 2;  // ours: a quarter of the work; what it loses at edges depth mends
};

/// The grey image that flow works on, `downscale` times smaller than `rgb` (CV_8UC3).
cv::Mat flow_image(const cv::Mat& rgb, const FlowOptions& options);

/// For each pixel of `to` where it was in `from`: CV_32FC2, displacement from `to` to `from` in pixels of
/// these images. No propagation from patch to patch, whose result would depend on OpenCV's number of threads.
cv::Mat backward_flow(const cv::Mat& to, const cv::Mat& from, const FlowOptions& options);

/// The positions that the pixels of `region` had: CV_32FC2 of the region's size in pixels of the full image,
/// from a flow on images `downscale` times smaller.
cv::Mat origins(const cv::Mat& flow, const cv::Rect& region, int downscale);

}  // namespace uniquadric
