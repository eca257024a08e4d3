#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// How masks are fitted to the edges that depth shows.
struct MaskEdgeOptions {
  int reach_px = 4;    // ours: how far an outline may move; 0 leaves masks as they are
  double jump = 0.03;  // ours: relative; a smaller step of depth across an outline is not taken for an edge
};

/// Moves the outlines of masks (CV_16UC1 ids, 0 none) to the edges of depth (CV_32FC1 [m], 0 none) near them:
/// where the body's depth inside and the depth outside differ clearly, each pixel between goes to the side
/// whose depth is nearer to its own; pixels without depth go with their neighbours. Of a body too thin
/// to have an inside the depth is what was `expected` (CV_32FC1 [m], 0 not known; may be empty).
cv::Mat fit_to_depth_edges(const cv::Mat& masks, const cv::Mat& depth, const cv::Mat& expected,
                           const MaskEdgeOptions& options);

}  // namespace uniquadric
