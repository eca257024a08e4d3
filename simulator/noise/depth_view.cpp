#include "simulator/noise/depth_view.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "simulator/noise/stereo_depth.h"

namespace uniquadric {
namespace {

// What a camera cannot see that stands `focal_baseline` / f_x to the right; negative: to the left.
cv::Mat hidden_from(const cv::Mat& depth_m, double focal_baseline, const cv::Mat& columns) {
  if (focal_baseline >= 0) return stereo_shadow(depth_m, focal_baseline, columns);
  cv::Mat mirrored, mirrored_columns, hidden;
  cv::flip(depth_m, mirrored, 1);
  if (!columns.empty()) cv::flip(-columns, mirrored_columns, 1);  // they grow to the right again
  cv::flip(stereo_shadow(mirrored, -focal_baseline, mirrored_columns), hidden, 1);
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

// The same behind a lens, which moves a pixel along a bent line.
cv::Mat moved_behind_lens(const cv::Mat& depth_m, const PixelRays& rays, double offset_m) {
  cv::Mat moved = cv::Mat::zeros(depth_m.size(), CV_32FC1);
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u) {
      const float z_m = depth_m.at<float>(v, u);
      if (!(z_m > 0)) continue;
      const Eigen::Vector2d ray = rays.at(u, v);
      const auto pixel = rays.camera.project({ray.x() - offset_m / z_m, ray.y(), 1});
      if (!pixel || !rays.camera.contains(*pixel)) continue;
      const cv::Point place(cvRound(pixel->x()), cvRound(pixel->y()));
      if (!cv::Rect({0, 0}, depth_m.size()).contains(place)) continue;
      float& there = moved.at<float>(place);
      if (there == 0 || z_m < there) there = z_m;
    }
  return moved;
}

cv::Mat shifted(const cv::Mat& depth_m, const Eigen::Vector2d& by_px) {
  const cv::Rect image({0, 0}, depth_m.size());
  const cv::Point by(cvRound(by_px.x()), cvRound(by_px.y()));
  const cv::Rect target = image & (image + by);
  cv::Mat moved = cv::Mat::zeros(depth_m.size(), CV_32FC1);
  if (!target.empty()) depth_m(target - by).copyTo(moved(target));
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

cv::Mat seen_from_depth_camera(const cv::Mat& depth_m, const cv::Mat& true_m, const PixelRays& rays,
                               const DepthNoise& noise) {
  cv::Mat seen = depth_m.clone();
  const double focal_baseline = rays.camera.fx * noise.color_offset_m;
  if (focal_baseline != 0 && !noise.registered)
    seen = rays.rays.empty() ? moved_by_disparity(depth_m, focal_baseline)
                             : moved_behind_lens(depth_m, rays, noise.color_offset_m);
  if (focal_baseline != 0 && noise.registered)
    seen.setTo(0, hidden_from(true_m, focal_baseline, rays.columns));
  if (!noise.registration_error_px.isZero()) seen = shifted(seen, noise.registration_error_px);
  return seen;
}

}  // namespace uniquadric
