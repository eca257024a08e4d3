#include "estimator/segmentation/motion_split.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "estimator/images/rigid_motion.h"
#include "estimator/observation/outline.h"
#include "estimator/segmentation/moved_pixels.h"

namespace uniquadric {
namespace {

constexpr int kSmoothing_px = 11;  // of the border between two motions

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
  rigid.min_inliers = kLeastMovedPixels;
  std::vector<Pose> motions;
  const auto needed = static_cast<std::size_t>(options.min_share * static_cast<double>(pixels.size()));
  while (motions.size() < 2 && pixels.size() > std::max<std::size_t>(needed, kLeastMovedPixels)) {
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

}  // namespace

cv::Mat split_by_motion(const cv::Mat& parts, const RgbdImage& now, const EarlierImage& before,
                        const Camera& lens, const MotionSplitOptions& options, RandomStream& random) {
  const Camera camera = without_distortion(lens);
  cv::Mat split = parts.clone();
  const auto boxes = id_boxes(parts);
  int next = boxes.empty() ? 1 : boxes.rbegin()->first + 1;
  for (const auto& [label, box] : boxes) {
    const cv::Mat part = parts(box) == label;
    const auto pixels = moved_pixels(part, box, now, before, camera, options.samples);
    const auto motions = motions_of(pixels, camera, options, random);
    if (motions.size() < 2) continue;
    const cv::Mat second = second_share(box, part, pixels, camera, motions);
    const double share = cv::countNonZero(second) / static_cast<double>(cv::countNonZero(part));
    if (share >= options.min_share && share <= 1 - options.min_share) split(box).setTo(next++, second);
  }
  return split;
}

}  // namespace uniquadric
