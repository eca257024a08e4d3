#include "estimator/mask_tracking/flow_tracker.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr double kSeenShare = 0.3;  // of a mask, whose colours agree where it is found as a whole: it also
                                    // turns, and shows other sides
constexpr int kMargin = 3;          // small pixels around where nearest neighbours find a body

cv::Rect enlarged(const cv::Rect& small, int downscale, const cv::Size& size) {
  const cv::Rect wide(small.x - kMargin, small.y - kMargin, small.width + 2 * kMargin,
                      small.height + 2 * kMargin);
  return cv::Rect(wide.x * downscale, wide.y * downscale, wide.width * downscale, wide.height * downscale) &
         cv::Rect({0, 0}, size);
}

template <typename T>
T at_nearest(const cv::Mat& image, const cv::Vec2f& position) {
  const int x = std::clamp(static_cast<int>(std::lround(position[0])), 0, image.cols - 1);
  const int y = std::clamp(static_cast<int>(std::lround(position[1])), 0, image.rows - 1);
  return image.at<T>(y, x);
}

cv::Mat shrunk(const cv::Mat& image, const cv::Size& size, int how) {
  cv::Mat result;
  if (!image.empty()) cv::resize(image, result, size, 0, 0, how);
  return result;
}

bool is_at_border(const cv::Mat& mask) {
  const cv::Rect box = cv::boundingRect(mask);
  return box.x == 0 || box.y == 0 || box.br().x == mask.cols || box.br().y == mask.rows;
}

// Masks of the image's size as flow carries them, at the flow's size.
cv::Mat carried_small(const cv::Mat& masks, const cv::Mat& flow) {
  cv::Mat carried;
  cv::remap(shrunk(masks, flow.size(), cv::INTER_NEAREST), carried,
            origins(flow, cv::Rect({0, 0}, flow.size()), 1), {}, cv::INTER_NEAREST, cv::BORDER_REPLICATE);
  return carried;
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
        result.at<float>(v, u) = at_nearest<float>(depth, positions.at<cv::Vec2f>(v, u));
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

// The flow back from the next frame that a body's shift is.
cv::Mat flow_of(const BodyShift& shift, const cv::Size& size) {
  cv::Mat flow(size, CV_32FC2);
  for (int v = 0; v < size.height; ++v)
    for (int u = 0; u < size.width; ++u) {
      const cv::Point2f place(static_cast<float>(u), static_cast<float>(v));
      flow.at<cv::Point2f>(v, u) = shift.origin_of(place) - place;
    }
  return flow;
}

SmallImages small_images(const TrackedImage& from, const TrackedImage& to) {
  const cv::Size size = to.grey.size();
  const auto small = [&](const TrackedImage& image) {
    return SmallImage{shrunk(image.rgb, size, cv::INTER_AREA), shrunk(image.depth, size, cv::INTER_NEAREST)};
  };
  return {small(from), small(to)};
}

}  // namespace

// At the image's border it may leave.
bool FlowTracker::is_lost(const cv::Mat& mask, const CarriedBody& body) const {
  const int found = body.mask.empty() ? 0 : cv::countNonZero(body.mask);
  return found < options_.lost_share * cv::countNonZero(mask) && !is_at_border(mask);
}

void FlowTracker::prepare(TrackedImage& image, const TrackedImage* previous) const {
  image.grey = flow_image(image.rgb, options_.flow);
  if (previous) image.flow_to_previous = backward_flow(image.grey, previous->grey, options_.flow);
}

CarriedMasks FlowTracker::carry(const cv::Mat& masks, const TrackedImage& from,
                                const TrackedImage& to) const {
  const bool has_depth = !from.depth.empty() && !to.depth.empty();
  CarriedMasks carried{cv::Mat::zeros(masks.size(), CV_16UC1), {}};
  if (has_depth) carried.expected_depth = cv::Mat::zeros(masks.size(), CV_32FC1);
  const auto put = [&](int id, const CarriedBody& body) {
    const cv::Mat is_free = carried.masks(body.region) == 0;
    if (has_depth) body.expected_depth.copyTo(carried.expected_depth(body.region), body.mask & is_free);
    carried.masks(body.region).setTo(id, body.mask & is_free);
  };
  const cv::Mat& flow = to.flow_to_previous;
  auto boxes = id_boxes(carried_small(masks, flow));
  std::optional<SmallImages> small;                // where a body is looked for
  std::vector<std::pair<int, CarriedBody>> found;  // as wholes: what flow says of other bodies comes first
  for (const auto& entry : id_boxes(masks)) {
    const int id = entry.first;
    const cv::Mat mask = masks == id;
    const CarriedBody body = carry_body(mask, boxes[id], from, to, flow);
    std::optional<CarriedBody> whole;
    if (is_lost(mask, body)) {
      if (!small) small = small_images(from, to);
      whole = find_whole(mask, body, *small, from, to);
    }
    if (whole)
      found.emplace_back(id, std::move(*whole));
    else if (!body.region.empty())
      put(id, body);
  }
  for (const auto& [id, body] : found) put(id, body);
  return carried;
}

FlowTracker::CarriedBody FlowTracker::carry_body(const cv::Mat& mask, const cv::Rect& small_box,
                                                 const TrackedImage& from, const TrackedImage& to,
                                                 const cv::Mat& flow) const {
  if (small_box.empty()) return {};
  CarriedBody body;
  body.region = enlarged(small_box, options_.flow.downscale, mask.size());
  body.origins = origins(flow, body.region, options_.flow.downscale);
  cv::remap(mask, body.mask, body.origins, {}, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  body.mask = body.mask > 127;
  if (!from.depth.empty() && !to.depth.empty()) {
    const cv::Mat depth = to.depth(body.region);
    cv::Mat& expected = body.expected_depth;
    expected = depth_at_origins(body.mask, from.depth, body.origins);
    cv::add(expected, depth_change(body.mask, depth, expected, options_.max_depth_change), expected,
            expected > 0);
    keep_what_moved_along(body.mask, depth, expected, options_.depth_tolerance);
  }
  return body;
}

double FlowTracker::CarriedBody::seen_again(const TrackedImage& from, const TrackedImage& to,
                                            double color_scale) const {
  double sum = 0;
  for (int v = 0; v < region.height; ++v)
    for (int u = 0; u < region.width; ++u)
      if (mask.at<unsigned char>(v, u))
        sum += color_likeness(at_nearest<cv::Vec3b>(from.rgb, origins.at<cv::Vec2f>(v, u)),
                              to.rgb.at<cv::Vec3b>(region.y + v, region.x + u), color_scale);
  return sum;
}

// Flow comes from a coarse image, in which the background about a small body that moves far outweighs it. Its
// shift as a whole does not. Nothing where flow finds more of the body, or nothing like it is seen.
std::optional<FlowTracker::CarriedBody> FlowTracker::find_whole(const cv::Mat& mask,
                                                                const CarriedBody& by_flow,
                                                                const SmallImages& small,
                                                                const TrackedImage& from,
                                                                const TrackedImage& to) const {
  const cv::Size size = to.grey.size();
  const BodyShift shift =
      body_shift(shrunk(mask, size, cv::INTER_NEAREST), small.from, small.to,
                 {options_.depth_tolerance, options_.max_depth_change}, options_.most_turn_rad);
  const cv::Mat back = flow_of(shift, size);
  CarriedBody whole = carry_body(mask, cv::boundingRect(carried_small(mask, back)), from, to, back);
  const double seen = whole.seen_again(from, to, shift.color_scale);
  const double least =
      std::max(kSeenShare * cv::countNonZero(mask), by_flow.seen_again(from, to, shift.color_scale));
  if (!(seen > least)) return std::nullopt;
  return whole;
}

}  // namespace uniquadric
