#include "estimator/perception/motion_split.h"

#include <algorithm>
#include <cmath>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/base/quantile.h"
#include "core/geometry/pose.h"
#include "estimator/perception/outline.h"
#include "estimator/perception/rigid_motion.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

constexpr int kMinSamples = 30;    // of a motion
constexpr int kSmoothing_px = 11;  // of the border between two motions

struct MovedPixel {
  cv::Point pixel;
  PointSighting sighting;  // where it is now in the camera's frame, and where it was seen before
};

std::optional<MovedPixel> moved_pixel(const cv::Point& pixel, const RgbdImage& now, const RgbdImage& before,
                                      const cv::Vec2f& origin, const Camera& camera) {
  const double z = now.depth.at<float>(pixel);
  const cv::Point from(static_cast<int>(std::lround(origin[0])), static_cast<int>(std::lround(origin[1])));
  if (!(z > 0) || !cv::Rect({0, 0}, before.depth.size()).contains(from)) return std::nullopt;
  const double z_before = before.depth.at<float>(from);
  if (!(z_before > 0)) return std::nullopt;
  const auto point = depth_point(now.depth, camera, pixel.x, pixel.y);
  if (!point) return std::nullopt;
  constexpr double kDepthNoise = 0.01;  // relative, of a difference of two measurements
  return MovedPixel{pixel, {*point, {origin[0], origin[1]}, z_before, kDepthNoise * z}};
}

double error_px(const MovedPixel& moved, const Camera& camera, const Pose& motion) {
  const auto pixel = camera.project(motion * moved.sighting.point);
  return pixel ? (*pixel - moved.sighting.pixel).norm() : 1e9;
}

std::vector<PointSighting> sightings_of(const std::vector<MovedPixel>& pixels) {
  std::vector<PointSighting> sightings;
  for (const auto& pixel : pixels) sightings.push_back(pixel.sighting);
  return sightings;
}

// The one or two motions of a part's pixels.
std::vector<Pose> motions_of(std::vector<MovedPixel> pixels, const Camera& camera,
                             const MotionSplitOptions& options, RandomStream& random) {
  RigidMotionOptions rigid;
  rigid.pixel_sigma = options.gate_px / rigid.pixel_gate;
  rigid.min_inliers = kMinSamples;
  std::vector<Pose> motions;
  const auto needed = static_cast<std::size_t>(options.min_share * static_cast<double>(pixels.size()));
  while (motions.size() < 2 && pixels.size() > std::max<std::size_t>(needed, kMinSamples)) {
    const auto motion = fit_rigid_motion(sightings_of(pixels), camera, std::nullopt, rigid, random);
    if (!motion) break;
    motions.push_back(motion->camera_from_body);
    std::erase_if(pixels,
                  [&](const MovedPixel& p) { return error_px(p, camera, motions.back()) < options.gate_px; });
  }
  return motions;
}

// 255 where the second motion explains a part's pixels better than the first, smoothed.
cv::Mat second_share(const cv::Rect& box, const cv::Mat& part, const std::vector<MovedPixel>& pixels,
                     const Camera& camera, const std::vector<Pose>& motions) {
  cv::Mat votes = cv::Mat::zeros(box.size(), CV_32FC1), weights = cv::Mat::zeros(box.size(), CV_32FC1);
  for (const MovedPixel& moved : pixels) {
    const cv::Point at = moved.pixel - box.tl();
    weights.at<float>(at) = 1;
    votes.at<float>(at) = error_px(moved, camera, motions[1]) < error_px(moved, camera, motions[0]);
  }
  const cv::Size window(4 * kSmoothing_px + 1, 4 * kSmoothing_px + 1);
  cv::GaussianBlur(votes, votes, window, kSmoothing_px, kSmoothing_px, cv::BORDER_CONSTANT);
  cv::GaussianBlur(weights, weights, window, kSmoothing_px, kSmoothing_px, cv::BORDER_CONSTANT);
  return (votes > 0.5 * weights) & part;
}

cv::Mat exact_flow(const RgbdImage& now, const RgbdImage& before) {
  const FlowOptions options{FlowOptions::Preset::medium, 1};  // exact: nothing mends its errors here
  return backward_flow(flow_image(now.rgb, options), flow_image(before.rgb, options), options);
}

// About `samples` pixels of a mask (CV_8UC1 of the box's size), and where they were.
std::vector<MovedPixel> moved_pixels(const cv::Mat& mask, const cv::Rect& box, const cv::Mat& flow,
                                     const RgbdImage& now, const RgbdImage& before, const Camera& camera,
                                     int samples) {
  const cv::Mat positions = origins(flow, box, 1);
  const int step = std::max(1, static_cast<int>(std::sqrt(cv::countNonZero(mask) / double(samples))));
  std::vector<MovedPixel> pixels;
  for (int v = 0; v < box.height; v += step)
    for (int u = 0; u < box.width; u += step)
      if (mask.at<unsigned char>(v, u))
        if (const auto moved =
                moved_pixel({box.x + u, box.y + v}, now, before, positions.at<cv::Vec2f>(v, u), camera))
          pixels.push_back(*moved);
  return pixels;
}

double median_error_px(const std::vector<MovedPixel>& pixels, const Camera& camera, const Pose& motion) {
  std::vector<double> errors;
  for (const MovedPixel& pixel : pixels) errors.push_back(error_px(pixel, camera, motion));
  return errors.empty() ? 0 : upper_median(std::move(errors));
}

// What two images say of a pixel of the later one, had it stood still.
struct StillPixel {
  bool was_in_view = false;  // it was within the image, and behind nothing nearer
  double error_px = 0;       // of the flow
  double grey_error = 0;     // of the place where it would have been
  double flow_grey_error = 0;
};

StillPixel had_it_stood_still(const MovedPixel& moved, const cv::Mat& grey_now, const cv::Mat& grey_before,
                              const cv::Mat& depth_before, const Camera& camera, const Pose& motion) {
  constexpr double kNearer = 0.03;  // relative: what hides it
  const cv::Rect image({0, 0}, depth_before.size());
  const auto rounded = [](const Eigen::Vector2d& p) {
    return cv::Point(static_cast<int>(std::lround(p.x())), static_cast<int>(std::lround(p.y())));
  };
  const Eigen::Vector3d point = motion * moved.sighting.point;
  const auto place = camera.project(point);
  if (!place || !image.contains(rounded(*place))) return {};
  const double z = depth_before.at<float>(rounded(*place));
  const auto difference = [&](const cv::Point& before) {
    return std::abs(double(grey_now.at<unsigned char>(moved.pixel)) - grey_before.at<unsigned char>(before));
  };
  return {!(z > 0) || z > (1 - kNearer) * point.z(), (*place - moved.sighting.pixel).norm(),
          difference(rounded(*place)), difference(rounded(moved.sighting.pixel))};
}

// The rigid motion that two fifths of an image's pixels or more have, within `gate_px`. By their places
// alone: depth far away is too noisy to vote.
std::optional<Pose> background_motion(const std::vector<MovedPixel>& pixels, const Camera& camera,
                                      double gate_px) {
  constexpr double kLeastShare = 0.4, kConfidence = 0.999;
  constexpr int kIterations = 200;
  if (std::ssize(pixels) < kMinSamples) return std::nullopt;
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

}  // namespace

cv::Mat split_by_motion(const cv::Mat& parts, const RgbdImage& now, const RgbdImage& before,
                        const Camera& lens, const MotionSplitOptions& options, RandomStream& random) {
  const Camera camera = without_distortion(lens);
  const cv::Mat flow = exact_flow(now, before);
  cv::Mat split = parts.clone();
  const auto boxes = id_boxes(parts);
  int next = boxes.empty() ? 1 : boxes.rbegin()->first + 1;
  for (const auto& [label, box] : boxes) {
    const cv::Mat part = parts(box) == label;
    const auto pixels = moved_pixels(part, box, flow, now, before, camera, options.samples);
    const auto motions = motions_of(pixels, camera, options, random);
    if (motions.size() < 2) continue;
    const cv::Mat second = second_share(box, part, pixels, camera, motions);
    const double share = cv::countNonZero(second) / static_cast<double>(cv::countNonZero(part));
    if (share >= options.min_share && share <= 1 - options.min_share) split(box).setTo(next++, second);
  }
  return split;
}

std::optional<cv::Mat> moving_parts(const cv::Mat& parts, const RgbdImage& now, const RgbdImage& before,
                                    const cv::Mat& keeps, const Camera& lens,
                                    const MotionSplitOptions& options) {
  constexpr int kBackgroundSamples = 3000;
  constexpr double kBend = 0.1;      // share by which a rolling shutter bends a fast motion
  constexpr double kEvidence = 0.1;  // of a body's pixels: the edges of a plain one
  const Camera camera = without_distortion(lens);
  const cv::Mat flow = exact_flow(now, before);
  const cv::Rect image({0, 0}, parts.size());
  const auto all = moved_pixels(cv::Mat(parts.size(), CV_8UC1, cv::Scalar(255)), image, flow, now, before,
                                camera, kBackgroundSamples);
  const auto background =
      background_motion(all, camera, std::max(options.gate_px, kBend * median_error_px(all, camera, Pose{})));
  if (!background) return std::nullopt;
  const FlowOptions whole{FlowOptions::Preset::medium, 1};
  const cv::Mat grey_now = flow_image(now.rgb, whole), grey_before = flow_image(before.rgb, whole);
  const auto still_pixels = [&](const std::vector<MovedPixel>& pixels) {
    std::vector<StillPixel> still;
    for (const MovedPixel& pixel : pixels)
      if (const StillPixel s =
              had_it_stood_still(pixel, grey_now, grey_before, before.depth, camera, *background);
          s.was_in_view)
        still.push_back(s);
    return still;
  };
  const auto background_pixels = still_pixels(all);
  const auto median_of = [](const std::vector<StillPixel>& pixels, double StillPixel::*member) {
    std::vector<double> values;
    for (const StillPixel& pixel : pixels) values.push_back(pixel.*member);
    return values.empty() ? 0 : upper_median(std::move(values));
  };
  const double gate_px =
      std::max(options.gate_px, options.moving_ratio * median_of(background_pixels, &StillPixel::error_px));
  const double grey_gate =
      options.moving_ratio * std::max(1.0, median_of(background_pixels, &StillPixel::grey_error));
  cv::Mat moving = parts.clone();
  for (const auto& [label, box] : id_boxes(parts)) {
    const cv::Mat part = parts(box) == label;
    if (!keeps.empty() && 2 * cv::countNonZero((keeps(box) != 0) & part) > cv::countNonZero(part)) continue;
    const auto pixels = still_pixels(moved_pixels(part, box, flow, now, before, camera, options.samples));
    const auto contradicted = std::ranges::count_if(
        pixels, [&](const StillPixel& p) { return p.grey_error > p.flow_grey_error + grey_gate; });
    const bool has_evidence =
        std::ssize(pixels) >= kMinSamples &&
        static_cast<double>(contradicted) > kEvidence * static_cast<double>(pixels.size());
    if (!has_evidence || median_of(pixels, &StillPixel::error_px) <= gate_px) moving(box).setTo(0, part);
  }
  return moving;
}

}  // namespace uniquadric
