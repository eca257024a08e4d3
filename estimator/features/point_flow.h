#pragma once

#include <Eigen/Core>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

namespace uniquadric {

/// Of the pyramidal Lucas-Kanade tracker. All numbers are ours.
struct PointFlowOptions {
  static constexpr int window_px = 15;  // side; larger windows take in what lies behind a small body
  int levels = 3;  // above the image itself: 15 px of window reach 60 px of error in the seed
  int iterations = 20;
  static constexpr double min_eigenvalue = 1e-4;    // of the patch's structure, as OpenCV norms it
  static constexpr double max_round_trip_px = 0.7;  // forward and backward again
};

/// An image and its pyramid for tracking.
struct FlowImage {
  std::vector<cv::Mat> pyramid;
};
FlowImage make_flow_image(const cv::Mat& gray, const PointFlowOptions& options);

/// Where the points of one image are in the next one, searched from `seeds`; nothing for those lost or not
/// found again on the way back. The same result for any number of threads.
std::vector<std::optional<Eigen::Vector2d>> follow_points(const FlowImage& before, const FlowImage& now,
                                                          const std::vector<Eigen::Vector2d>& points,
                                                          const std::vector<Eigen::Vector2d>& seeds,
                                                          const PointFlowOptions& options);

}  // namespace uniquadric
