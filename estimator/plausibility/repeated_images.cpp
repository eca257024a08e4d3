#include "estimator/plausibility/repeated_images.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr double kMoved_px = 1;    // median of the corners' ways, of colour that moved
constexpr double kRepeated = 0.5;  // of the pairs
constexpr std::size_t kLeastPairs = 3;

bool is_moved(const FramePair& pair) {
  std::vector<double> ways_px;
  for (const PointPair& point : pair.points) ways_px.push_back((point.raw_b - point.raw_a).norm());
  return !ways_px.empty() && quantile(std::move(ways_px), 0.5) > kMoved_px;
}

bool is_same(const std::filesystem::path& a, const std::filesystem::path& b) {
  try {
    const cv::Mat first = read_image(a), second = read_image(b);
    return first.size() == second.size() && first.type() == second.type() && cv::countNonZero(first) > 0 &&
           cv::norm(first, second, cv::NORM_INF) == 0;
  } catch (const InputError&) {
    return false;
  }
}

std::vector<std::string> suspicions_of(const Sequence& sequence, const std::vector<FramePair>& pairs,
                                       std::filesystem::path SequenceFrame::*file, const char* list) {
  std::size_t moved = 0, same = 0;
  for (const FramePair& pair : pairs) {
    if (!is_moved(pair)) continue;
    ++moved;
    const auto &a = sequence.frames[pair.first].*file, &b = sequence.frames[pair.second].*file;
    same += !a.empty() && !b.empty() && is_same(sequence.folder / a, sequence.folder / b);
  }
  if (moved < kLeastPairs || static_cast<double>(same) <= kRepeated * static_cast<double>(moved)) return {};
  return {
      fmt::format("{}: the same image stands in both of {} of {} pairs of frames whose colour moves: one may "
                  "have been written for all",
                  (sequence.folder / list).string(), same, moved)};
}

}  // namespace

std::vector<std::string> repeated_depth_suspicions(const Sequence& sequence,
                                                   const std::vector<FramePair>& pairs) {
  return suspicions_of(sequence, pairs, &SequenceFrame::depth, "depth.txt");
}

std::vector<std::string> repeated_mask_suspicions(const Sequence& sequence,
                                                  const std::vector<FramePair>& pairs) {
  return suspicions_of(sequence, pairs, &SequenceFrame::masks, "masks.txt");
}

}  // namespace uniquadric
