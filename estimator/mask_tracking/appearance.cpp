#include "estimator/mask_tracking/appearance.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kHueBins = 12, kSaturationBins = 3, kGreyBins = 6;
constexpr int kColourBins = kHueBins * kSaturationBins;
constexpr int kHues = 180;          // OpenCV's 8-bit hue
constexpr int kMinSaturation = 40;  // of 255: hue below is mostly noise

// The bin of an HSV pixel: hue and saturation for colours, brightness for greys.
int bin_of(const cv::Vec3b& hsv) {
  if (hsv[1] < kMinSaturation) return kColourBins + hsv[2] * kGreyBins / 256;
  const int saturation = (hsv[1] - kMinSaturation) * kSaturationBins / (256 - kMinSaturation);
  return (hsv[0] * kHueBins / kHues) * kSaturationBins + saturation;
}

std::vector<double> colours_of(const cv::Mat& mask, const cv::Mat& rgb) {
  cv::Mat hsv;
  cv::cvtColor(rgb, hsv, cv::COLOR_BGR2HSV);
  std::vector<double> bins(kColourBins + kGreyBins);
  double count = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask.at<unsigned char>(v, u)) {
        bins[bin_of(hsv.at<cv::Vec3b>(v, u))] += 1;
        count += 1;
      }
  for (double& bin : bins) bin /= std::max(count, 1.0);
  return bins;
}

std::optional<double> median_depth_under(const cv::Mat& mask, const cv::Mat& depth) {
  std::vector<float> values;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask.at<unsigned char>(v, u) && depth.at<float>(v, u) > 0) values.push_back(depth.at<float>(v, u));
  if (values.empty()) return std::nullopt;
  return upper_median(std::move(values));
}

}  // namespace

Appearance appearance_of(const cv::Mat& mask, const cv::Rect& region, const cv::Mat& rgb,
                         const cv::Mat& depth, const Camera& camera) {
  Appearance appearance;
  appearance.colours = colours_of(mask, rgb(region));
  const cv::Moments moments = cv::moments(mask, true);
  appearance.area_px = moments.m00;
  if (depth.empty()) return appearance;
  const auto z = median_depth_under(mask, depth(region));
  if (!z) return appearance;
  appearance.area_m2 = moments.m00 * *z * *z / (camera.fx * camera.fy);
  const Eigen::Vector2d middle(region.x + moments.m10 / moments.m00, region.y + moments.m01 / moments.m00);
  if (const auto ray = camera.unproject(middle)) appearance.place_m = *z * *ray;
  return appearance;
}

double colour_similarity(const Appearance& a, const Appearance& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.colours.size(); ++i) sum += std::sqrt(a.colours[i] * b.colours[i]);
  return sum;
}

}  // namespace uniquadric
