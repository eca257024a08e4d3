#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// How masks are fitted to the edges that depth and colours show.
struct MaskEdgeOptions {
  int reach_px = 4;    // ours: how far an outline may move; 0 leaves masks as they are
  double jump = 0.03;  // ours: relative; a smaller step of depth across an outline is not taken for an edge
  bool colors = true;  // where depth tells nothing, colours do
};

/// What outlines are fitted to, all of one size.
struct EdgeImages {
  cv::Mat rgb;       ///< CV_8UC3; may be empty
  cv::Mat depth;     ///< CV_32FC1 [m], 0 none
  cv::Mat expected;  ///< the same under the masks, as far as it is known; may be empty
};

/// Moves the outlines of masks (CV_16UC1 ids, 0 none) to the edges near them. A pixel that depth reaches from
/// one side alone, without a step, goes to that side. Where it is reached from both, as where a body stands,
/// or where depth is missing, it goes where its colour clearly belongs (color_sides.h), or else stays. Of a
/// body too thin to have an inside, what has the expected depth is inside.
cv::Mat fit_to_edges(const cv::Mat& masks, const EdgeImages& images, const MaskEdgeOptions& options);

}  // namespace uniquadric
