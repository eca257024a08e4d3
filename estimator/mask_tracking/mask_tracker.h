#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// One frame as a mask tracker sees it.
struct TrackedImage {
  std::int64_t frame = 0;
  cv::Mat rgb;                     ///< CV_8UC3
  cv::Mat depth;                   ///< CV_32FC1 [m], 0 none; may be empty
  cv::Mat grey, flow_to_previous;  ///< of the flow tracker, filled by prepare()
};

/// Masks in a frame to which they were carried.
struct CarriedMasks {
  cv::Mat masks;  ///< CV_16UC1 ids
  cv::Mat
      expected_depth;  ///< CV_32FC1: what the bodies' depth should be there [m], 0 not known; may be empty
};

/// Carries masks from a frame to the next.
class MaskTracker {
 public:
  virtual ~MaskTracker() = default;
  /// What is done once a frame, whatever is carried to it; `previous` is nothing for the first.
  virtual void prepare(TrackedImage& image, const TrackedImage* previous) const = 0;
  /// Learns bodies by their masks (CV_16UC1 ids) in a frame.
  virtual void learn(const cv::Mat& masks, const TrackedImage& image) = 0;
  /// The masks of a frame as they are in the next one.
  virtual CarriedMasks carry(const cv::Mat& masks, const TrackedImage& from,
                             const TrackedImage& to) const = 0;
};

}  // namespace uniquadric
