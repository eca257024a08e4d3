#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <mutex>
#include <opencv2/core/mat.hpp>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "estimator/segmentation/prompts.h"

namespace uniquadric {

/// Which of the user's prompts led to a mask of their own. Thread-safe.
class PromptWatch {
 public:
  /// `ids_last`: ids name objects over the frames; else each prompt is an object of its own.
  PromptWatch(std::filesystem::path prompts, bool ids_last)
      : prompts_(std::move(prompts)), ids_last_(ids_last) {}

  /// A prompt at a stamp, as messages name it: "point (3, 4)".
  void expect(std::int64_t stamp_ns, int id, const std::string& name);
  void found(std::int64_t stamp_ns, int id);

  struct Placed {
    std::int64_t stamp_ns = 0;
    PointPrompt point;
  };
  /// Warns that two points of different objects lie on one mask: there is one object then. Each pair of ids
  /// that last is said once.
  void share(const Placed& first, const Placed& second);

  /// A line for each object of whose prompts none led to a mask, a few of them at most.
  std::vector<std::string> faults() const;

 private:
  using Key = std::pair<std::int64_t, int>;  // stamp (0 where ids last), id
  Key key_of(std::int64_t stamp_ns, int id) const { return {ids_last_ ? 0 : stamp_ns, id}; }

  struct Expected {
    std::int64_t first_ns = 0;
    std::string name;  // of the first
    int count = 0;
    bool found = false;
  };

  std::filesystem::path prompts_;
  bool ids_last_;
  std::map<Key, Expected> expected_;
  std::set<std::pair<int, int>> said_;  // ids that share a mask
  mutable std::mutex mutex_;
};

/// The pairs of points, in their order, of which `masks` (CV_16UC1, by the points' ids) gives the one's mask
/// to the other and nothing to itself.
std::vector<std::pair<PointPrompt, PointPrompt>> points_on_one_mask(const cv::Mat& masks,
                                                                    const std::vector<PointPrompt>& points);

}  // namespace uniquadric
