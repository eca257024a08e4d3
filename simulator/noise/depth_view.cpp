#include "simulator/noise/depth_view.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/noise/stereo_depth.h"

namespace uniquadric {
namespace {

// What a camera cannot see that stands `focal_baseline` / f_x to the right; negative: to the left.
cv::Mat hidden_from(const cv::Mat& depth_m, double focal_baseline) {
  if (focal_baseline >= 0) return stereo_shadow(depth_m, focal_baseline);
  cv::Mat mirrored, hidden;
  cv::flip(depth_m, mirrored, 1);
  cv::flip(stereo_shadow(mirrored, -focal_baseline), hidden, 1);
  return hidden;
}

cv::Mat moved_by_disparity(const cv::Mat& depth_m, double focal_baseline) {
  cv::Mat moved = cv::Mat::zeros(depth_m.size(), CV_32FC1);
  for (int v = 0; v < depth_m.rows; ++v) {
    const auto* z_m = depth_m.ptr<float>(v);
    auto* target = moved.ptr<float>(v);
    for (int u = 0; u < depth_m.cols; ++u) {
      if (!(z_m[u] > 0)) continue;
      const double place = std::round(u - focal_baseline / z_m[u]);
      if (place < 0 || place >= depth_m.cols) continue;
      float& there = target[static_cast<int>(place)];
      if (there == 0 || z_m[u] < there) there = z_m[u];
    }
  }
  return moved;
}

cv::Mat shifted(const cv::Mat& depth_m, const Eigen::Vector2d& by_px) {
  const cv::Matx23d to_source(1, 0, -by_px.x(), 0, 1, -by_px.y());
  cv::Mat moved;
  cv::warpAffine(depth_m, moved, to_source, depth_m.size(), cv::INTER_NEAREST | cv::WARP_INVERSE_MAP);
  return moved;
}

}  // namespace

void smear_disparity(cv::Mat& depth_m, const cv::Mat& edges, double smear_px) {
  const int side = 2 * static_cast<int>(std::lround(smear_px)) + 1;
  const cv::Size window(side, side);
  cv::Mat valid, disparity, near, sum, count;
  cv::dilate(edges, near, cv::getStructuringElement(cv::MORPH_RECT, window));
  cv::Mat(depth_m > 0).convertTo(valid, CV_32F, 1.0 / 255);
  cv::divide(1.0, depth_m, disparity);
  disparity.setTo(0, depth_m <= 0);
  cv::boxFilter(disparity, sum, CV_32F, window, {-1, -1}, false);
  cv::boxFilter(valid, count, CV_32F, window, {-1, -1}, false);
  cv::divide(count, sum, sum);
  sum.copyTo(depth_m, near & (depth_m > 0));
}

cv::Mat seen_from_depth_camera(const cv::Mat& depth_m, const cv::Mat& true_m, const Camera& camera,
                               const DepthNoise& noise) {
  cv::Mat seen = depth_m.clone();
  const double focal_baseline = camera.fx * noise.color_offset_m;
  if (focal_baseline != 0 && !noise.registered) seen = moved_by_disparity(depth_m, focal_baseline);
  if (focal_baseline != 0 && noise.registered) seen.setTo(0, hidden_from(true_m, focal_baseline));
  if (!noise.registration_error_px.isZero()) seen = shifted(seen, noise.registration_error_px);
  return seen;
}

}  // namespace uniquadric
