#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

enum class DeltaUnit { frames, metres, seconds, degrees };
const char* to_string(DeltaUnit unit);  ///< f, m, s, deg

struct Delta {
  double value = 1;
  DeltaUnit unit = DeltaUnit::frames;
};
/// 1f, 10.5m, 1s, 10deg: greater than 0, whole for frames; nothing for other texts.
std::optional<Delta> parse_delta(std::string_view text);

/// Which poses a relative error compares.
struct DeltaOptions {
  double delta = 1;
  DeltaUnit unit = DeltaUnit::frames;
  double tolerance = 0.1;  ///< share of delta that a pair may be off (metres, seconds, degrees); SPEC: 10 %
  bool all_pairs = false;  ///< from every pose, instead of each pair starting where the last one ended
};

/// From pose i to pose j > i.
struct IndexStep {
  std::size_t i = 0, j = 0;
  bool operator==(const IndexStep&) const = default;
};

/// Steps over `poses` (metres along the path, seconds of the stamps, degrees turned since i), in order of i.
/// From each start the pose nearest to `delta` is taken, the first of equals; starts that have none within
/// the tolerance are left out. In degrees, which may shrink again, the search ends with the first pose that
/// has turned by more than delta and the tolerance, or that leaves the tolerance after one was in it. Throws
/// InputError for a delta that is not positive, or not whole for frames.
std::vector<IndexStep> delta_steps(const std::vector<Pose>& poses, const std::vector<std::int64_t>& stamps_ns,
                                   const DeltaOptions& options);

}  // namespace uniquadric
