#include "estimator/perception/flow_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/perception/outline.h"

namespace uniquadric {
namespace {

constexpr int kMargin = 3;  // small pixels around where nearest neighbours find a body

cv::Rect enlarged(const cv::Rect& small, int downscale, const cv::Size& size) {
  const cv::Rect wide(small.x - kMargin, small.y - kMargin, small.width + 2 * kMargin,
                      small.height + 2 * kMargin);
  return cv::Rect(wide.x * downscale, wide.y * downscale, wide.width * downscale, wide.height * downscale) &
         cv::Rect({0, 0}, size);
}

float at_nearest(const cv::Mat& image, const cv::Vec2f& position) {
  const int x = std::clamp(static_cast<int>(std::lround(position[0])), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(position[1])), 0, image.rows - 1);
  return image.at<float>(y, x);
}

// By how much the depth under a mask has changed since: the median over pixels that may still be the body;
// 0 where nothing is measured at both times.
float depth_change(const cv::Mat& mask, const cv::Mat& now, const cv::Mat& before, double most) {
  std::vector<float> changes;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      const float z = now.at<float>(v, u), z_before = before.at<float>(v, u);
      if (mask.at<unsigned char>(v, u) && z > 0 && z_before > 0 && std::abs(z - z_before) < most * z_before)
        changes.push_back(z - z_before);
    }
  if (changes.empty()) return 0;
  return upper_median(std::move(changes));
}

// Depth where the pixels under a mask come from; 0 elsewhere and where it is not measured.
cv::Mat depth_at_origins(const cv::Mat& mask, const cv::Mat& depth, const cv::Mat& positions) {
  cv::Mat result = cv::Mat::zeros(mask.size(), CV_32FC1);
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask.at<unsigned char>(v, u))
        result.at<float>(v, u) = at_nearest(depth, positions.at<cv::Vec2f>(v, u));
  return result;
}

// Takes out of a mask the pixels whose depth is not as expected, and their expectation with them.
void keep_what_moved_along(cv::Mat& mask, const cv::Mat& depth, cv::Mat& expected, double tolerance) {
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      const float z = depth.at<float>(v, u);
      float& wanted = expected.at<float>(v, u);
      if (z > 0 && wanted > 0 && std::abs(z - wanted) > tolerance * z) mask.at<unsigned char>(v, u) = 0;
    }
}

}  // namespace

void FlowTracker::prepare(TrackedImage& image, const TrackedImage* previous) const {
  image.grey = flow_image(image.rgb, options_.flow);
  if (previous) image.flow_to_previous = backward_flow(image.grey, previous->grey, options_.flow);
}

CarriedMasks FlowTracker::carry(const cv::Mat& masks, const TrackedImage& from,
                                const TrackedImage& to) const {
  const cv::Mat& flow = to.flow_to_previous;
  const bool has_depth = !from.depth.empty() && !to.depth.empty();
  cv::Mat small, small_carried;
  cv::resize(masks, small, flow.size(), 0, 0, cv::INTER_NEAREST);
  cv::remap(small, small_carried, origins(flow, cv::Rect({0, 0}, flow.size()), 1), {}, cv::INTER_NEAREST,
            cv::BORDER_REPLICATE);
  CarriedMasks carried{cv::Mat::zeros(masks.size(), CV_16UC1), {}};
  if (has_depth) carried.expected_depth = cv::Mat::zeros(masks.size(), CV_32FC1);
  for (const auto& [id, box] : id_boxes(small_carried)) {
    const cv::Rect region = enlarged(box, options_.flow.downscale, masks.size());
    const cv::Mat positions = origins(flow, region, options_.flow.downscale);
    cv::Mat found;
    cv::remap(masks == id, found, positions, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    found = found > 127;
    if (has_depth) {
      cv::Mat expected = depth_at_origins(found, from.depth, positions);
      cv::add(expected, depth_change(found, to.depth(region), expected, options_.max_depth_change), expected,
              expected > 0);
      expected.copyTo(carried.expected_depth(region), found);
      keep_what_moved_along(found, to.depth(region), expected, options_.depth_tolerance);
    }
    carried.masks(region).setTo(id, found);
  }
  return carried;
}

}  // namespace uniquadric
