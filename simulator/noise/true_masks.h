#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>

namespace uniquadric {

/// The pixels of one id.
struct TrueMask {
  cv::Rect box;
  std::int64_t pixels = 0;
};

/// Of an image of ids (16UC1), 0 being nothing.
std::map<int, TrueMask> find_masks(const cv::Mat& ids);

}  // namespace uniquadric
