#include "estimator/segmentation/moving_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/quantile.h"
#include "estimator/observation/outline.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

constexpr int kSamples = 400, kImageSamples = 3000;  // pixels of a part, and of the image
constexpr int kOthers = 300;                         // pixels that tell what errors do at a part's distance
constexpr int kLeastPixels = 30;                     // fewer tell nothing
constexpr int kEdge_px = 5;                          // across: at edges of depth the nearer side counts
constexpr double kEvidence = 0.1;                    // of a part's pixels in view
constexpr double kInView = 0.5;                      // of a part's pixels
constexpr int kTimes = 2;                            // one earlier image may err

// What an earlier image shows at the place where a pixel would have been, had it stood still: depths over its
// own. Nothing where nothing is measured.
struct Place {
  double depth, nearest;  // at the place, and the least about it
};

class EarlierView {
 public:
  EarlierView(const EarlierDepth& before, const Camera& camera) : before_(before), camera_(camera) {
    constexpr float kFar_m = 1e9F;
    cv::Mat measured = before.depth.clone();
    measured.setTo(kFar_m, before.depth <= 0);
    cv::erode(measured, nearest_, cv::Mat::ones(kEdge_px, kEdge_px, CV_8UC1));
  }

  std::optional<Place> place(const Eigen::Vector3d& point) const {
    const Eigen::Vector3d still = before_.before_from_now * point;
    const auto pixel = camera_.project(still);
    if (!pixel || !camera_.contains(*pixel)) return std::nullopt;
    const cv::Point at(std::min(static_cast<int>(pixel->x() + 0.5), camera_.width - 1),
                       std::min(static_cast<int>(pixel->y() + 0.5), camera_.height - 1));
    const double z = before_.depth.at<float>(at);
    if (!(z > 0)) return std::nullopt;
    return Place{z / still.z(), nearest_.at<float>(at) / still.z()};
  }

 private:
  EarlierDepth before_;
  Camera camera_;
  cv::Mat nearest_;
};

// About `samples` pixels of a mask with depth.
std::vector<cv::Point> some_pixels(const cv::Mat& mask, const cv::Point& corner, int samples) {
  const int step = std::max(1, static_cast<int>(std::sqrt(cv::countNonZero(mask) / double(samples))));
  std::vector<cv::Point> pixels;
  for (int v = step / 2; v < mask.rows; v += step)
    for (int u = step / 2; u < mask.cols; u += step)
      if (mask.at<unsigned char>(v, u)) pixels.push_back(corner + cv::Point(u, v));
  return pixels;
}

using Places = std::vector<std::optional<Place>>;  // of pixels

// Share of the places in view that lay free: what is seen there is farther by more than `errors` (relative).
// 0 where too few were in view.
double free_share(const Places& places, double errors) {
  int in_view = 0, free = 0;
  for (const auto& place : places) {
    if (!place || place->depth < 1 - errors) continue;  // hidden
    ++in_view;
    free += place->nearest > 1 + errors ? 1 : 0;
  }
  const double least = std::max<double>(kLeastPixels, kInView * static_cast<double>(places.size()));
  return in_view < least ? 0 : static_cast<double>(free) / in_view;
}

// A depth image, and what earlier ones tell of its pixels.
class StillWorld {
 public:
  StillWorld(const cv::Mat& parts, const cv::Mat& depth, const std::vector<EarlierDepth>& earlier,
             const Camera& camera, double ratio)
      : parts_(parts), depth_(depth), camera_(camera), ratio_(ratio) {
    for (const EarlierDepth& before : earlier) views_.emplace_back(before, camera);
    pixels_ = some_pixels(depth > 0, {0, 0}, kImageSamples);
  }

  bool has_moved(int label, const cv::Rect& box) const;

 private:
  Places places(const EarlierView& view, const std::vector<cv::Point>& pixels) const;
  // Pixels about as far away as those of a part, and not on it.
  std::vector<cv::Point> others_at(int label, const std::vector<cv::Point>& own) const;

  cv::Mat parts_, depth_;
  Camera camera_;
  double ratio_;
  std::vector<EarlierView> views_;
  std::vector<cv::Point> pixels_;
};

bool StillWorld::has_moved(int label, const cv::Rect& box) const {
  const auto own = some_pixels((parts_(box) == label) & (depth_(box) > 0), box.tl(), kSamples);
  if (std::ssize(own) < kLeastPixels) return false;
  const auto others = others_at(label, own);
  const auto says_so = [&](const EarlierView& view) {
    std::vector<double> errors;
    for (const auto& place : places(view, others))
      if (place) errors.push_back(std::abs(place->depth - 1));
    if (std::ssize(errors) < kLeastPixels) return false;
    return free_share(places(view, own), ratio_ * upper_median(std::move(errors))) > kEvidence;
  };
  return std::ranges::count_if(views_, says_so) >= kTimes;
}

Places StillWorld::places(const EarlierView& view, const std::vector<cv::Point>& pixels) const {
  Places result;
  for (const cv::Point& pixel : pixels) {
    const auto point = depth_point(depth_, camera_, pixel.x, pixel.y);
    result.push_back(point ? view.place(*point) : std::nullopt);
  }
  return result;
}

std::vector<cv::Point> StillWorld::others_at(int label, const std::vector<cv::Point>& own) const {
  std::vector<double> depths;
  for (const cv::Point& pixel : own) depths.push_back(depth_.at<float>(pixel));
  const double z = upper_median(std::move(depths));
  std::vector<cv::Point> others;
  for (const cv::Point& pixel : pixels_)
    if (parts_.at<std::uint16_t>(pixel) != label) others.push_back(pixel);
  std::ranges::stable_sort(
      others, {}, [&](const cv::Point& pixel) { return std::abs(std::log(depth_.at<float>(pixel) / z)); });
  others.resize(std::min<std::size_t>(others.size(), kOthers));
  return others;
}

}  // namespace

cv::Mat moving_parts(const cv::Mat& parts, const cv::Mat& depth, const std::vector<EarlierDepth>& earlier,
                     const cv::Mat& keeps, const Camera& camera, double ratio) {
  const StillWorld world(parts, depth, earlier, camera, ratio);
  cv::Mat moving = parts.clone();
  for (const auto& [label, box] : id_boxes(parts)) {
    const cv::Mat part = parts(box) == label;
    const bool is_kept =
        !keeps.empty() && 2 * cv::countNonZero((keeps(box) != 0) & part) > cv::countNonZero(part);
    if (!is_kept && !world.has_moved(label, box)) moving(box).setTo(0, part);
  }
  return moving;
}

}  // namespace uniquadric
