#pragma once

#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// A frame's colours (CV_8UC3) and depth (CV_32FC1 [m], 0 none; may be empty) at the size of the flow.
struct SmallImage {
  cv::Mat rgb, depth;
};

/// A frame and the next one.
struct SmallImages {
  SmallImage from, to;
};

/// Limits of what counts as one body in two frames, relative to its depth.
struct DepthAgreement {
  double tolerance = 0;    ///< between a pixel's change of depth and the body's
  double most_change = 0;  ///< of the body
};

/// Where a body's mask went as a whole: it turned about its middle, and was shifted then.
struct BodyShift {
  cv::Point pixels;        ///< along columns and rows
  double turn_rad = 0;     ///< from columns to rows
  cv::Point2f middle;      ///< in the first frame
  double color_scale = 1;  ///< mean difference of colour between the body and anything near it

  cv::Point2f moved(const cv::Point2f& from) const;    ///< where a place of the body went
  cv::Point2f origin_of(const cv::Point2f& to) const;  ///< where it came from
};

/// How like two colours are, from 1, the same, to 0, no more alike than any two.
double color_likeness(const cv::Vec3b& a, const cv::Vec3b& b, double color_scale);

/// How a body's mask (CV_8UC1) has moved from a frame to the next: where most of it is seen again with its
/// colours, and with its depth but for one change of it all. It is looked for within its own size, and turned
/// by up to `most_turn_rad` either way.
BodyShift body_shift(const cv::Mat& mask, const SmallImage& from, const SmallImage& to,
                     const DepthAgreement& agreement, double most_turn_rad);

}  // namespace uniquadric
