#include "estimator/mask_tracking/local_mean.h"

#include <opencv2/imgproc.hpp>

namespace uniquadric {

cv::Mat local_mean(const cv::Mat& values, const cv::Mat& chosen, int window) {
  cv::Mat weights, sums, counts;
  cv::Mat(chosen != 0).convertTo(weights, CV_32F, 1 / 255.0);
  cv::boxFilter(values.mul(weights), sums, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::boxFilter(weights, counts, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  cv::Mat mean = sums / counts;
  mean.setTo(0, counts < 0.5);
  return mean;
}

}  // namespace uniquadric
