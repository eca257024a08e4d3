#include "simulator/noise/true_masks.h"

namespace uniquadric {

std::map<int, TrueMask> find_masks(const cv::Mat& ids) {
  std::map<int, TrueMask> masks;
  for (int v = 0; v < ids.rows; ++v) {
    const auto* row = ids.ptr<std::uint16_t>(v);
    for (int u = 0; u < ids.cols;) {
      const int id = row[u], begin = u;
      while (u < ids.cols && row[u] == id) ++u;
      if (id == 0) continue;
      TrueMask& mask = masks[id];
      mask.box = mask.pixels ? mask.box | cv::Rect(begin, v, u - begin, 1) : cv::Rect(begin, v, u - begin, 1);
      mask.pixels += u - begin;
    }
  }
  return masks;
}

}  // namespace uniquadric
