#include "estimator/perception/corners.h"

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
bool is_inside(const Place& p, const cv::Mat& image) {
  return p.u >= 0 && p.v >= 0 && p.u < image.cols && p.v < image.rows;
}

// 255 where all neighbours have the same label.
cv::Mat interior(const cv::Mat& labels) {
  cv::Mat low, high;
  cv::erode(labels, low, cv::Mat());
  cv::dilate(labels, high, cv::Mat());
  return low == high;
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
  return is_inside(p, labels) ? labels.at<std::uint16_t>(p.v, p.u) : -1;
}

double Regions::margin(const Eigen::Vector2d& pixel) const {
  const Place p = place_of(pixel);
  return is_inside(p, margin_px) ? margin_px.at<float>(p.v, p.u) : 0;
}

Regions make_regions(const cv::Mat& masks, cv::Size size) {
  Regions regions;
  if (masks.empty())
    regions.labels = cv::Mat::zeros(size, CV_16UC1);
  else
    regions.labels = masks;
  const cv::Mat inside = interior(regions.labels);
  if (cv::countNonZero(inside) == inside.rows * inside.cols)
    regions.margin_px = cv::Mat(size, CV_32FC1, cv::Scalar(std::max(size.width, size.height)));
  else
    cv::distanceTransform(inside, regions.margin_px, cv::DIST_L2, 3);
  return regions;
}

Spacing::Spacing(cv::Size size) : taken_(cv::Mat::zeros(size, CV_8UC1)) {}

bool Spacing::is_free(const Eigen::Vector2d& pixel) const {
  const Place p = place_of(pixel);
  return is_inside(p, taken_) && taken_.at<std::uint8_t>(p.v, p.u) == 0;
}

void Spacing::take(const Eigen::Vector2d& pixel, double distance_px) {
  const Place p = place_of(pixel);
  const int reach = static_cast<int>(distance_px);
  const cv::Rect square(p.u - reach, p.v - reach, 2 * reach + 1, 2 * reach + 1);
  taken_(square & cv::Rect(0, 0, taken_.cols, taken_.rows)).setTo(1);
}

}  // namespace uniquadric
