#include "estimator/perception/mask_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>

#include "estimator/perception/outline.h"

namespace uniquadric {
namespace {

constexpr double kThinCore = 0.3;  // a body is thin when less of its mask is farther inside than the reach

enum Side : unsigned char { undecided, inside, outside, unmeasured };

// Mean depth over the chosen pixels of a window around each pixel; 0 where it holds none.
cv::Mat local_depth(const cv::Mat& depth, const cv::Mat& chosen, int window) {
  cv::Mat weights, sums, counts;
  cv::Mat(chosen & (depth > 0)).convertTo(weights, CV_32F, 1 / 255.0);
  cv::boxFilter(depth.mul(weights), sums, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(weights, counts, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat mean = sums / counts;
  mean.setTo(0, counts < 0.5);
  return mean;
}

// What depth says of the pixels near a mask's outline.
struct Band {
  cv::Mat sides;    // CV_8UC1 of Side
  cv::Mat inner_m;  // CV_32FC1: the body's depth nearby
};

// The body's depth around each pixel: of its inside; of a body that has hardly any, as it was expected.
cv::Mat body_depth(const cv::Mat& mask, const cv::Mat& core, const cv::Mat& depth, const cv::Mat& expected,
                   int window) {
  cv::Mat nearby = local_depth(depth, core, window);
  if (expected.empty() || cv::countNonZero(core) > kThinCore * cv::countNonZero(mask)) return nearby;
  local_depth(expected, expected > 0, window).copyTo(nearby, nearby == 0);
  return nearby;
}

Band decide(const cv::Mat& mask, const cv::Mat& depth, const cv::Mat& expected,
            const MaskEdgeOptions& options) {
  const int reach = options.reach_px, window = 4 * reach + 1;
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1});
  cv::Mat core, wide;
  cv::erode(mask, core, square, {-1, -1}, 1, cv::BORDER_REPLICATE);  // the image's border is no outline
  cv::dilate(mask, wide, square);
  Band band{cv::Mat(mask.size(), CV_8UC1, cv::Scalar(undecided)),
            body_depth(mask, core, depth, expected, window)};
  const cv::Mat outer_m = local_depth(depth, ~wide, window);
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      if (core.at<unsigned char>(v, u) || !wide.at<unsigned char>(v, u)) continue;
      const float z = depth.at<float>(v, u), in = band.inner_m.at<float>(v, u), out = outer_m.at<float>(v, u);
      if (!(in > 0 && out > 0) || std::abs(in - out) < options.jump * in) continue;
      band.sides.at<unsigned char>(v, u) = !(z > 0)                               ? unmeasured
                                           : std::abs(z - in) < std::abs(z - out) ? inside
                                                                                  : outside;
    }
  return band;
}

// A pixel at an edge but without depth goes with most of its eight neighbours.
void settle_unmeasured(Band& band, const cv::Mat& mask) {
  const cv::Mat before = band.sides.clone();
  const auto is_in = [&](int v, int u) {
    const auto side = before.at<unsigned char>(v, u);
    return side == inside || (side != outside && mask.at<unsigned char>(v, u));
  };
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      if (before.at<unsigned char>(v, u) != unmeasured) continue;
      int votes = 0;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, mask.rows - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, mask.cols - 1); ++x)
          if (before.at<unsigned char>(y, x) != unmeasured) votes += is_in(y, x) ? 1 : -1;
      if (votes != 0) band.sides.at<unsigned char>(v, u) = votes > 0 ? inside : outside;
    }
}

}  // namespace

cv::Mat fit_to_depth_edges(const cv::Mat& masks, const cv::Mat& depth, const cv::Mat& expected,
                           const MaskEdgeOptions& options) {
  cv::Mat fitted = masks.clone();
  if (options.reach_px == 0 || depth.empty()) return fitted;
  cv::Mat misfit(masks.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::max()));
  const int margin = 3 * options.reach_px;
  const cv::Rect image({0, 0}, masks.size());
  for (const auto& [id, box] : id_boxes(masks)) {
    const cv::Rect region =
        cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) & image;
    const cv::Mat mask = masks(region) == id;
    cv::Mat expected_of_id;
    if (!expected.empty()) {
      expected_of_id = cv::Mat::zeros(region.size(), CV_32FC1);
      expected(region).copyTo(expected_of_id, mask);
    }
    Band band = decide(mask, depth(region), expected_of_id, options);
    settle_unmeasured(band, mask);
    for (int v = 0; v < region.height; ++v)
      for (int u = 0; u < region.width; ++u) {
        const auto side = band.sides.at<unsigned char>(v, u);
        auto& label = fitted.at<std::uint16_t>(region.y + v, region.x + u);
        if (side == outside && label == id) label = 0;
        if (side != inside) continue;
        const float z = depth.at<float>(region.y + v, region.x + u);
        const float distance = z > 0 ? std::abs(z - band.inner_m.at<float>(v, u)) : 0;
        float& least = misfit.at<float>(region.y + v, region.x + u);
        if (distance >= least || (z <= 0 && label != 0)) continue;
        least = distance;
        label = static_cast<std::uint16_t>(id);
      }
  }
  return fitted;
}

}  // namespace uniquadric
