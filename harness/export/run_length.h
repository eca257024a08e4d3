#pragma once

#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace uniquadric {

/// COCO's uncompressed run-length code of the pixels of an id in a 16UC1 mask: run lengths column by column,
/// zeros first (so that a mask whose first pixel is set begins with 0).
std::vector<std::int64_t> run_lengths(const cv::Mat& ids, int id);

}  // namespace uniquadric
