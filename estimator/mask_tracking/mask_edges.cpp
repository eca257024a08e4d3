#include "estimator/mask_tracking/mask_edges.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "estimator/mask_tracking/color_sides.h"
#include "estimator/mask_tracking/local_mean.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr float kClearly = 1.5F;   // log of the odds that colours have to give against what a mask says
constexpr int kHole = 5;           // pixels with depth about one without, of eight
constexpr double kThinCore = 0.3;  // a body is thin when less of its mask is farther inside than the reach

enum Side : unsigned char { undecided, inside, outside };

// What is told of the pixels near a mask's outline.
struct Band {
  cv::Mat sides;    // CV_8UC1 of Side
  cv::Mat inner_m;  // CV_32FC1: the body's depth nearby
};

// 255 on the pixels of the band that are reached from the seeds in `steps` steps through the band, none of
// them a step of depth of `jump` or more. A slanted face is many small steps. What is only reached by a long
// way round, as a standing body over its foot, has an edge.
cv::Mat reached(const cv::Mat& seeds, const cv::Mat& band, const cv::Mat& depth, double jump, int steps) {
  cv::Mat beside, result = cv::Mat::zeros(depth.size(), CV_8UC1);
  cv::dilate(band, beside, {});
  std::vector<cv::Point> front, next_front;
  cv::findNonZero(seeds & beside & (depth > 0), front);
  for (int step = 0; step < steps && !front.empty(); ++step) {
    next_front.clear();
    for (const cv::Point& from : front) {
      const float z = depth.at<float>(from);
      for (int y = std::max(from.y - 1, 0); y <= std::min(from.y + 1, depth.rows - 1); ++y)
        for (int x = std::max(from.x - 1, 0); x <= std::min(from.x + 1, depth.cols - 1); ++x) {
          const float next = depth.at<float>(y, x);
          if (!band.at<unsigned char>(y, x) || result.at<unsigned char>(y, x) || !(next > 0) ||
              std::abs(next - z) >= jump * std::min(next, z))
            continue;
          result.at<unsigned char>(y, x) = 255;
          next_front.emplace_back(x, y);
        }
    }
    std::swap(front, next_front);
  }
  return result;
}

// The pixels that are surely the body's: well inside of the mask or, of a body too thin to have an inside,
// those of its expected depth.
cv::Mat sure_pixels(const cv::Mat& mask, const cv::Mat& core, bool is_thin, const EdgeImages& images,
                    double jump) {
  if (!is_thin) return core;
  if (images.expected.empty()) return cv::Mat::zeros(mask.size(), CV_8UC1);
  return mask & (images.depth > 0) & (cv::abs(images.depth - images.expected) < jump * images.expected);
}

Band decide(const cv::Mat& mask, const EdgeImages& images, const MaskEdgeOptions& options) {
  const int reach = options.reach_px, window = 4 * reach + 1;
  const cv::Mat square = cv::getStructuringElement(cv::MORPH_RECT, {2 * reach + 1, 2 * reach + 1});
  cv::Mat core, wide;
  cv::erode(mask, core, square, {-1, -1}, 1, cv::BORDER_REPLICATE);  // the image's border is no outline
  cv::dilate(mask, wide, square);
  const cv::Mat between = wide & ~core;
  const bool is_thin = cv::countNonZero(core) <= kThinCore * cv::countNonZero(mask);
  const cv::Mat sure = sure_pixels(mask, core, is_thin, images, options.jump);
  Band band{cv::Mat(mask.size(), CV_8UC1, cv::Scalar(undecided)),
            local_mean(images.depth, sure & (images.depth > 0), window)};
  const bool has_sure = cv::countNonZero(sure) > 0;
  if (has_sure) {
    const cv::Mat from_inside = reached(sure, between, images.depth, options.jump, 2 * reach);
    const cv::Mat from_outside = reached(~wide, between, images.depth, options.jump, 2 * reach);
    band.sides.setTo(inside, from_inside & ~from_outside);
    band.sides.setTo(outside, from_outside & ~from_inside);
    // something else that came into view
    band.sides.setTo(outside, between & ~from_inside & ~mask & (images.depth > 0));
  }
  if (images.rgb.empty() || !options.colors) return band;
  // body and support meet without a step, or depth is missing
  const cv::Mat asked = between & (band.sides == undecided);
  const cv::Mat ratio = color_sides(images.rgb, has_sure ? sure : mask, ~wide, asked, window);
  band.sides.setTo(inside, ratio > kClearly);
  band.sides.setTo(outside, ratio < -kClearly);
  return band;
}

// A hole of depth at an edge goes with most of its eight neighbours.
void fill_holes(Band& band, const cv::Mat& mask, const cv::Mat& depth) {
  const cv::Mat before = band.sides.clone();
  const auto is_in = [&](int v, int u) {
    const auto side = before.at<unsigned char>(v, u);
    return side == inside || (side != outside && mask.at<unsigned char>(v, u));
  };
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      if (before.at<unsigned char>(v, u) != undecided || depth.at<float>(v, u) > 0) continue;
      int votes = 0, measured = 0;
      for (int y = std::max(v - 1, 0); y <= std::min(v + 1, mask.rows - 1); ++y)
        for (int x = std::max(u - 1, 0); x <= std::min(u + 1, mask.cols - 1); ++x)
          if (depth.at<float>(y, x) > 0) votes += is_in(y, x) ? 1 : -1, ++measured;
      if (measured >= kHole && votes != 0) band.sides.at<unsigned char>(v, u) = votes > 0 ? inside : outside;
    }
}

struct FittedBody {
  std::uint16_t id;
  cv::Rect region;
  Band band;
};

// Each body takes what is inside of it and has been left to nobody, the one whose depth is nearer before
// others. What another body keeps is its own: bodies side by side have no edge between them.
void take_what_is_free(cv::Mat& fitted, const cv::Mat& depth, const std::vector<FittedBody>& bodies) {
  const cv::Mat is_free = fitted == 0;
  cv::Mat misfit(fitted.size(), CV_32FC1, cv::Scalar(std::numeric_limits<float>::max()));
  for (const FittedBody& body : bodies)
    for (int y = 0; y < body.region.height; ++y)
      for (int x = 0; x < body.region.width; ++x) {
        const int v = body.region.y + y, u = body.region.x + x;
        if (body.band.sides.at<unsigned char>(y, x) != inside || !is_free.at<unsigned char>(v, u)) continue;
        const float z = depth.at<float>(v, u);
        const float distance = z > 0 ? std::abs(z - body.band.inner_m.at<float>(y, x)) : 0;
        if (distance >= misfit.at<float>(v, u)) continue;
        misfit.at<float>(v, u) = distance;
        fitted.at<std::uint16_t>(v, u) = body.id;
      }
}

}  // namespace

cv::Mat fit_to_edges(const cv::Mat& masks, const EdgeImages& images, const MaskEdgeOptions& options) {
  cv::Mat fitted = masks.clone();
  if (options.reach_px == 0 || images.depth.empty()) return fitted;
  const int margin = 6 * options.reach_px;
  const cv::Rect image({0, 0}, masks.size());
  std::vector<FittedBody> bodies;
  for (const auto& [id, box] : id_boxes(masks)) {
    const cv::Rect region =
        cv::Rect(box.x - margin, box.y - margin, box.width + 2 * margin, box.height + 2 * margin) & image;
    const cv::Mat mask = masks(region) == id;
    EdgeImages here{images.rgb.empty() ? cv::Mat() : images.rgb(region), images.depth(region), {}};
    if (!images.expected.empty()) {
      here.expected = cv::Mat::zeros(region.size(), CV_32FC1);
      images.expected(region).copyTo(here.expected, mask);
    }
    Band band = decide(mask, here, options);
    fill_holes(band, mask, here.depth);
    fitted(region).setTo(0, mask & (band.sides == outside));
    bodies.push_back({static_cast<std::uint16_t>(id), region, std::move(band)});
  }
  take_what_is_free(fitted, images.depth, bodies);
  return fitted;
}

}  // namespace uniquadric
