#include "simulator/lidar/reflectivity.h"

#include <opencv2/core.hpp>

namespace uniquadric {

float mean_luminance(const Mesh& mesh) {
  const cv::Scalar bgr = mesh.texture.empty() ? cv::Scalar::all(255) : cv::mean(mesh.texture);
  return static_cast<float>((0.2126 * bgr[2] * mesh.color.x() + 0.7152 * bgr[1] * mesh.color.y() +
                             0.0722 * bgr[0] * mesh.color.z()) /
                            255);
}

}  // namespace uniquadric
