#pragma once

#include <cstdint>
#include <filesystem>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <set>
#include <utility>
#include <vector>

#include "estimator/perception/prompts.h"

namespace uniquadric {

/// Says on stderr where two point prompts of different objects lie on one mask: there is one object then, and
/// the other prompt finds nothing. Thread-safe.
class SharedMasks {
 public:
  /// `ids_last`: ids name objects over the frames, and each pair of them is said once.
  SharedMasks(std::filesystem::path prompts, bool ids_last)
      : prompts_(std::move(prompts)), ids_last_(ids_last) {}

  struct Placed {
    std::int64_t stamp_ns = 0;
    PointPrompt point;
  };
  void say(const Placed& first, const Placed& second);

 private:
  std::filesystem::path prompts_;
  bool ids_last_;
  std::set<std::pair<int, int>> said_;
  std::mutex mutex_;
};

/// The pairs of points, in their order, of which `masks` (CV_16UC1, by the points' ids) gives the one's mask
/// to the other and nothing to itself.
std::vector<std::pair<PointPrompt, PointPrompt>> points_on_one_mask(const cv::Mat& masks,
                                                                    const std::vector<PointPrompt>& points);

}  // namespace uniquadric
