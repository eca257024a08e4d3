#include "estimator/plausibility/repeated_images.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr double kMoved_px = 1;       // median of the corners' ways, of colour that moved
constexpr double kRepeated = 0.5;     // of the pairs
constexpr std::size_t kLeastPairs = 3;

bool is_moved(const FramePair& pair) {
  std::vector<double> ways_px;
  for (const PointPair& point : pair.points) ways_px.push_back((point.raw_b - point.raw_a).norm());
  return !ways_px.empty() && quantile(std::move(ways_px), 0.5) > kMoved_px;
}

bool is_same(const std::filesystem::path& a, const std::filesystem::path& b) {
  if (a.empty() || b.empty()) return false;
  try {
    const cv::Mat first = read_image(a), second = read_image(b);
    return first.size() == second.size() && first.type() == second.type() &&
           cv::countNonZero(first) > 0 && cv::norm(first, second, cv::NORM_INF) == 0;
  } catch (const InputError&) {
    return false;
  }
}

}  // namespace

std::vector<std::string> repeat_suspicions(const Sequence& sequence, const std::vector<FramePair>& pairs) {
  std::size_t moved = 0, same_depth = 0, same_masks = 0;
  for (const FramePair& pair : pairs) {
    if (!is_moved(pair)) continue;
    ++moved;
    const SequenceFrame &a = sequence.frames[pair.first], &b = sequence.frames[pair.second];
    const auto path = [&](const std::filesystem::path& file) { return file.empty() ? file : sequence.folder / file; };
    same_depth += is_same(path(a.depth), path(b.depth));
    same_masks += is_same(path(a.masks), path(b.masks));
  }
  std::vector<std::string> found;
  const auto tell = [&](const char* file, const char* what, std::size_t same) {
    if (moved >= kLeastPairs && static_cast<double>(same) > kRepeated * static_cast<double>(moved))
      found.push_back(fmt::format("{}: {} the same image in {} of {} pairs of frames whose colour moves: one image may stand for all",
                                  (sequence.folder / file).string(), what, same, moved));
  };
  tell("depth.txt", "depth is", same_depth);
  tell("masks.txt", "masks are", same_masks);
  return found;
}

}  // namespace uniquadric
