#include "core/import/rectify.h"

#include <opencv2/imgproc.hpp>

namespace uniquadric {

cv::Mat rectify(const Camera& camera, const cv::Mat& image, bool interpolate) {
  if (!camera.has_distortion()) return image;
  cv::Mat u(image.size(), CV_32F), v(image.size(), CV_32F);
  for (int row = 0; row < image.rows; ++row)
    for (int column = 0; column < image.cols; ++column) {
      const auto pixel =
          camera.project({(column - camera.cx) / camera.fx, (row - camera.cy) / camera.fy, 1.0});
      u.at<float>(row, column) = static_cast<float>(pixel->x());
      v.at<float>(row, column) = static_cast<float>(pixel->y());
    }
  cv::Mat rectified;
  cv::remap(image, rectified, u, v, interpolate ? cv::INTER_LINEAR : cv::INTER_NEAREST);
  return rectified;
}

}  // namespace uniquadric
