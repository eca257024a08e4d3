#pragma once

#include <algorithm>
#include <opencv2/core.hpp>

namespace uniquadric {

/// Byte for byte.
inline bool same(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  const cv::Mat x = a.clone(), y = b.clone();  // of parts of images the rows do not touch
  return std::equal(x.datastart, x.dataend, y.datastart);
}

}  // namespace uniquadric
