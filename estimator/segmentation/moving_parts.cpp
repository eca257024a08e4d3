#include "estimator/segmentation/moving_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <optional>

#include "core/base/quantile.h"
#include "estimator/observation/outline.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

// All numbers are ours.
constexpr int kSamples = 400, kImageSamples = 3000;  // pixels of a part, and of the image
constexpr int kOthers = 300;                         // pixels that tell the errors at a part's distance
constexpr int kLeastPixels = 30;                     // fewer tell nothing
constexpr double kEvidence = 0.2;                    // of a part's pixels in view: errors seldom free so many
constexpr double kInView = 0.5;                      // of a part's pixels
constexpr double kGreyRatio = 2;                     // to the median error of grey
constexpr double kLeastGrey = 1;                     // levels: its unit
constexpr int kLeastReach_px = 2;                    // inliers of the motion's fit are off by as much
constexpr int kTimes = 2;                            // one earlier image may err

// A pixel with depth.
struct Sample {
  cv::Point pixel;
  Eigen::Vector3d point;  // camera frame [m]
  double grey;
};

// What an earlier image shows where a sample would have been, had it stood still.
struct Place {
  cv::Point pixel;
  double still_m;     // the sample's depth
  double depth;       // of what is seen, over the sample's
  double grey_error;  // levels
};

// Median errors, had samples stood still.
struct Errors {
  double depth;  // relative
  double grey;   // levels
};

class EarlierView {
 public:
  EarlierView(const EarlierImages& images, const Camera& camera) : images_(images), camera_(camera) {}

  // Nothing out of view, and where nothing is measured.
  std::optional<Place> place(const Sample& sample) const {
    const Eigen::Vector3d still = images_.before_from_now * sample.point;
    const auto pixel = camera_.project(still);
    if (!pixel || !camera_.contains(*pixel)) return std::nullopt;
    const cv::Point at(std::min(static_cast<int>(pixel->x() + 0.5), camera_.width - 1),
                       std::min(static_cast<int>(pixel->y() + 0.5), camera_.height - 1));
    const double z = images_.depth.at<float>(at);
    if (!(z > 0)) return std::nullopt;
    return Place{at, still.z(), z / still.z(),
                 std::abs(sample.grey - double(images_.gray.at<unsigned char>(at)))};
  }

  // Nothing where too few are in view.
  std::optional<Errors> errors(const std::vector<Sample>& samples) const {
    std::vector<double> depth, grey;
    for (const Sample& sample : samples)
      if (const auto place = this->place(sample)) {
        depth.push_back(std::abs(place->depth - 1));
        grey.push_back(place->grey_error);
      }
    if (std::ssize(depth) < kLeastPixels) return std::nullopt;
    return Errors{upper_median(std::move(depth)), std::max(kLeastGrey, upper_median(std::move(grey)))};
  }

  // Share of the samples in view whose place was free. 0 where too few were in view.
  double free_share(const std::vector<Sample>& samples, const Errors& errors, double ratio) const {
    int in_view = 0, free = 0;
    for (const Sample& sample : samples) {
      const auto place = this->place(sample);
      if (!place || place->depth < 1 - ratio * errors.depth) continue;  // hidden
      ++in_view;
      free += is_free(*place, errors, ratio) ? 1 : 0;
    }
    const double least = std::max<double>(kLeastPixels, kInView * static_cast<double>(samples.size()));
    return in_view < least ? 0 : static_cast<double>(free) / in_view;
  }

 private:
  // An error of the camera's motion that shifts depth by a share shifts pixels by that share of the focal
  // length, so nothing within that many pixels may be as near as the part.
  bool is_free(const Place& place, const Errors& errors, double ratio) const {
    const double beyond = 1 + ratio * errors.depth;
    if (place.depth <= beyond || place.grey_error <= kGreyRatio * errors.grey) return false;
    const double shift_px = std::max(camera_.fx, camera_.fy) * errors.depth;
    const int reach = std::max(kLeastReach_px, static_cast<int>(std::ceil(shift_px)));
    const cv::Rect around(place.pixel - cv::Point(reach, reach), cv::Size(2 * reach + 1, 2 * reach + 1));
    const cv::Mat depth = images_.depth(around & cv::Rect({0, 0}, images_.depth.size()));
    return cv::countNonZero((depth > 0) & (depth <= beyond * place.still_m)) == 0;
  }

  EarlierImages images_;
  Camera camera_;
};

// A frame's parts, and what earlier ones tell of them.
class StillWorld {
 public:
  StillWorld(const cv::Mat& parts, const FrameImages& now, const std::vector<EarlierImages>& earlier,
             const Camera& camera, double ratio)
      : parts_(parts), now_(now), camera_(camera), ratio_(ratio) {
    for (const EarlierImages& images : earlier) views_.emplace_back(images, camera);
    samples_ = samples(now.depth > 0, {0, 0}, kImageSamples);
  }

  bool has_moved(int label, const cv::Rect& box) const {
    const auto own = samples(parts_(box) == label, box.tl(), kSamples);
    if (std::ssize(own) < kLeastPixels) return false;
    const auto others = others_at(label, own);
    const auto says_so = [&](const EarlierView& view) {
      const auto errors = view.errors(others);
      return errors && view.free_share(own, *errors, ratio_) > kEvidence;
    };
    return std::ranges::count_if(views_, says_so) >= kTimes;
  }

 private:
  // About `number` pixels of a mask.
  std::vector<Sample> samples(const cv::Mat& mask, const cv::Point& corner, int number) const {
    const int step = std::max(1, static_cast<int>(std::sqrt(cv::countNonZero(mask) / double(number))));
    std::vector<Sample> result;
    for (int v = step / 2; v < mask.rows; v += step)
      for (int u = step / 2; u < mask.cols; u += step) {
        const cv::Point pixel = corner + cv::Point(u, v);
        if (!mask.at<unsigned char>(v, u)) continue;
        if (const auto point = depth_point(now_.depth, camera_, pixel.x, pixel.y))
          result.push_back({pixel, *point, double(now_.gray.at<unsigned char>(pixel))});
      }
    return result;
  }

  // Samples of the image about as far away as those of a part, and not on it.
  std::vector<Sample> others_at(int label, const std::vector<Sample>& own) const {
    std::vector<double> depths;
    for (const Sample& sample : own) depths.push_back(sample.point.z());
    const double z = upper_median(std::move(depths));
    std::vector<Sample> others;
    for (const Sample& sample : samples_)
      if (parts_.at<std::uint16_t>(sample.pixel) != label) others.push_back(sample);
    std::ranges::stable_sort(others, {},
                             [&](const Sample& s) { return std::abs(std::log(s.point.z() / z)); });
    if (std::ssize(others) > kOthers) others.erase(others.begin() + kOthers, others.end());
    return others;
  }

  cv::Mat parts_;
  FrameImages now_;
  Camera camera_;
  double ratio_;
  std::vector<EarlierView> views_;
  std::vector<Sample> samples_;
};

}  // namespace

cv::Mat moving_parts(const cv::Mat& parts, const FrameImages& now, const std::vector<EarlierImages>& earlier,
                     const cv::Mat& keeps, const Camera& camera, double ratio) {
  const StillWorld world(parts, now, earlier, camera, ratio);
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
