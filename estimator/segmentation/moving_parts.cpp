#include "estimator/segmentation/moving_parts.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/images/dense_flow.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

// The rigid motion that two fifths of an image's pixels or more have, within `gate_px`. By their places
// alone: depth far away is too noisy to vote.
std::optional<Pose> background_motion(const std::vector<MovedPixel>& pixels, const Camera& camera,
                                      double gate_px) {
  constexpr double kLeastShare = 0.4, kConfidence = 0.999;
  constexpr int kIterations = 200;
  if (std::ssize(pixels) < kLeastMovedPixels) return std::nullopt;
  std::vector<cv::Point3d> points;
  std::vector<cv::Point2d> places;
  for (const MovedPixel& p : pixels) {
    points.emplace_back(p.sighting.point.x(), p.sighting.point.y(), p.sighting.point.z());
    places.emplace_back(p.sighting.pixel.x(), p.sighting.pixel.y());
  }
  const cv::Matx33d K(camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1);
  cv::Vec3d rotation, translation;
  std::vector<int> inliers;
  if (!cv::solvePnPRansac(points, places, K, cv::noArray(), rotation, translation, false, kIterations,
                          static_cast<float>(gate_px), kConfidence, inliers) ||
      static_cast<double>(inliers.size()) < kLeastShare * static_cast<double>(pixels.size()))
    return std::nullopt;
  return Pose{exp_so3({rotation[0], rotation[1], rotation[2]}),
              {translation[0], translation[1], translation[2]}};
}

// What two images say of a pixel of the later one, had it stood still.
struct StillPixel {
  bool was_in_view = false;  // it was within the image, and behind nothing nearer
  double error_px = 0;       // of the flow
  double grey_error = 0;     // of the place where it would have been
  double flow_grey_error = 0;
};

// Two images, and what the camera's own motion between them tells of each pixel.
class StillWorld {
 public:
  StillWorld(const RgbdImage& now, const EarlierImage& before, const Camera& camera)
      : now_(now), before_(before), camera_(camera) {
    const FlowOptions whole{FlowOptions::Preset::medium, 1};
    grey_now_ = flow_image(now.rgb, whole);
    grey_before_ = flow_image(before.rgb, whole);
  }

  // Whether the background has a motion; the other functions need one.
  bool find_background(double gate_px);
  // Those of about `samples` pixels of a mask (CV_8UC1 of the box's size) that were in view.
  std::vector<StillPixel> pixels(const cv::Mat& mask, const cv::Rect& box, int samples) const;
  std::vector<StillPixel> background_pixels() const { return judged(all_); }

 private:
  StillPixel judge(const MovedPixel& moved) const;
  std::vector<StillPixel> judged(const std::vector<MovedPixel>& pixels) const;

  RgbdImage now_;
  EarlierImage before_;
  Camera camera_;
  cv::Mat grey_now_, grey_before_;
  std::vector<MovedPixel> all_;
  Pose motion_;
};

bool StillWorld::find_background(double gate_px) {
  constexpr int kSamples = 3000;
  constexpr double kBend = 0.1;  // share by which a rolling shutter bends a fast motion
  const cv::Size size = now_.depth.size();
  all_ = moved_pixels(cv::Mat(size, CV_8UC1, cv::Scalar(255)), cv::Rect({0, 0}, size), now_, before_, camera_,
                      kSamples);
  std::vector<double> moved_px;
  for (const MovedPixel& pixel : all_) moved_px.push_back(error_px(pixel, camera_, Pose{}));
  if (moved_px.empty()) return false;
  const auto motion =
      background_motion(all_, camera_, std::max(gate_px, kBend * upper_median(std::move(moved_px))));
  if (motion) motion_ = *motion;
  return motion.has_value();
}

std::vector<StillPixel> StillWorld::pixels(const cv::Mat& mask, const cv::Rect& box, int samples) const {
  return judged(moved_pixels(mask, box, now_, before_, camera_, samples));
}

std::vector<StillPixel> StillWorld::judged(const std::vector<MovedPixel>& pixels) const {
  std::vector<StillPixel> still;
  for (const MovedPixel& pixel : pixels)
    if (const StillPixel s = judge(pixel); s.was_in_view) still.push_back(s);
  return still;
}

StillPixel StillWorld::judge(const MovedPixel& moved) const {
  constexpr double kNearer = 0.03;  // relative: what hides it
  const cv::Rect image({0, 0}, before_.depth.size());
  const auto rounded = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  };
  const Eigen::Vector3d point = motion_ * moved.sighting.point;
  const auto place = camera_.project(point);
  if (!place || !image.contains(rounded(*place))) return {};
  const double z = before_.depth.at<float>(rounded(*place));
  const auto difference = [&](const cv::Point& before) {
    return std::abs(double(grey_now_.at<unsigned char>(moved.pixel)) -
                    grey_before_.at<unsigned char>(before));
  };
  return {!(z > 0) || z > (1 - kNearer) * point.z(), (*place - moved.sighting.pixel).norm(),
          difference(rounded(*place)), difference(rounded(moved.sighting.pixel))};
}

double median_of(const std::vector<StillPixel>& pixels, double StillPixel::*member) {
  std::vector<double> values;
  for (const StillPixel& pixel : pixels) values.push_back(pixel.*member);
  return values.empty() ? 0 : upper_median(std::move(values));
}

// What a body at rest is off at most.
struct Gates {
  double error_px, grey_error;
};

bool has_moved(const std::vector<StillPixel>& pixels, const Gates& gates) {
  constexpr double kEvidence = 0.1;  // of a body's pixels: the edges of a plain one
  if (std::ssize(pixels) < kLeastMovedPixels) return false;
  const auto contradicted = std::ranges::count_if(
      pixels, [&](const StillPixel& p) { return p.grey_error > p.flow_grey_error + gates.grey_error; });
  return static_cast<double>(contradicted) > kEvidence * static_cast<double>(pixels.size()) &&
         median_of(pixels, &StillPixel::error_px) > gates.error_px;
}

}  // namespace

std::optional<cv::Mat> moving_parts(const cv::Mat& parts, const RgbdImage& now, const EarlierImage& before,
                                    const cv::Mat& keeps, const Camera& lens,
                                    const MotionSplitOptions& options) {
  StillWorld world(now, before, without_distortion(lens));
  if (!world.find_background(options.gate_px)) return std::nullopt;
  const auto background = world.background_pixels();
  const double ratio = options.moving_ratio;
  const Gates gates{std::max(options.gate_px, ratio * median_of(background, &StillPixel::error_px)),
                    ratio * std::max(1.0, median_of(background, &StillPixel::grey_error))};
  cv::Mat moving = parts.clone();
  for (const auto& [label, box] : id_boxes(parts)) {
    const cv::Mat part = parts(box) == label;
    const bool is_kept =
        !keeps.empty() && 2 * cv::countNonZero((keeps(box) != 0) & part) > cv::countNonZero(part);
    if (!is_kept && !has_moved(world.pixels(part, box, options.samples), gates)) moving(box).setTo(0, part);
  }
  return moving;
}

}  // namespace uniquadric
