#include "estimator/features/corners.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>

namespace uniquadric {
namespace {

struct Place {
  int u, v;
};
Place place_of(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}
bool lies_in(const Place& p, const cv::Mat& image) {
  return p.u >= 0 && p.v >= 0 && p.u < image.cols && p.v < image.rows;
}

bool is_set(const cv::Mat& image, const Eigen::Vector2d& pixel) {
  const Place p = place_of(pixel);
  return lies_in(p, image) && image.at<std::uint8_t>(p.v, p.u) != 0;
}

// 255 where all neighbours have the same label.
cv::Mat interior(const cv::Mat& labels) {
  cv::Mat low, high;
  cv::erode(labels, low, cv::Mat());
  cv::dilate(labels, high, cv::Mat());
  return low == high;
}

cv::Mat shrunk(const cv::Mat& inside, int by_px) {
  if (by_px <= 0) return inside;
  cv::Mat result;
  cv::erode(inside, result, cv::Mat::ones(2 * by_px + 1, 2 * by_px + 1, CV_8UC1));
  return result;
}

}  // namespace

std::vector<Corner> fast_corners(const cv::Mat& gray, int threshold) {
  std::vector<cv::KeyPoint> points;
  cv::FAST(gray, points, threshold, true);
  std::vector<Corner> corners;
  corners.reserve(points.size());
  for (const auto& p : points) corners.push_back({Eigen::Vector2d(p.pt.x, p.pt.y), p.response});
  std::stable_sort(corners.begin(), corners.end(),
                   [](const Corner& a, const Corner& b) { return a.response > b.response; });
  return corners;
}

int Regions::label(const Eigen::Vector2d& pixel) const {
  const Place p = place_of(pixel);
  return lies_in(p, labels) ? labels.at<std::uint16_t>(p.v, p.u) : -1;
}

bool Regions::is_inside(const Eigen::Vector2d& pixel) const {
  return is_set(keep, pixel);
}

bool Regions::is_well_inside(const Eigen::Vector2d& pixel) const {
  return is_set(start, pixel);
}

bool Regions::contains_patch(const Eigen::Vector2d& pixel) const {
  return is_set(patch, pixel);
}

Regions make_regions(const cv::Mat& masks, cv::Size size, int keep_px, int start_px, int patch_px) {
  Regions regions;
  if (masks.empty())
    regions.labels = cv::Mat::zeros(size, CV_16UC1);
  else
    regions.labels = masks;
  regions.keep = shrunk(interior(regions.labels), keep_px - 1);
  regions.start = shrunk(regions.keep, start_px - keep_px);
  regions.patch = shrunk(regions.keep, patch_px - keep_px);
  return regions;
}

Spacing::Spacing(cv::Size size) : taken_(cv::Mat::zeros(size, CV_8UC1)) {}

bool Spacing::is_free(const Eigen::Vector2d& pixel) const {
  const Place p = place_of(pixel);
  return lies_in(p, taken_) && taken_.at<std::uint8_t>(p.v, p.u) == 0;
}

void Spacing::take(const Eigen::Vector2d& pixel, double distance_px) {
  const Place p = place_of(pixel);
  const int reach = static_cast<int>(distance_px);
  const cv::Rect square(p.u - reach, p.v - reach, 2 * reach + 1, 2 * reach + 1);
  taken_(square & cv::Rect(0, 0, taken_.cols, taken_.rows)).setTo(1);
}

}  // namespace uniquadric
