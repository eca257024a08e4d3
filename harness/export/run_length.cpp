#include "harness/export/run_length.h"

namespace uniquadric {

std::vector<std::int64_t> run_lengths(const cv::Mat& ids, int id) {
  std::vector<std::int64_t> runs = {0};
  bool inside = false;
  for (int u = 0; u < ids.cols; ++u)
    for (int v = 0; v < ids.rows; ++v) {
      if ((ids.at<std::uint16_t>(v, u) == id) != inside) {
        runs.push_back(0);
        inside = !inside;
      }
      ++runs.back();
    }
  return runs;
}

}  // namespace uniquadric
