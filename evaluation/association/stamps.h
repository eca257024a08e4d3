#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

namespace uniquadric {

enum class StampRule {
  nearest,     ///< evo's: for each pose of the shorter list the nearest of the other; one may be taken twice
  one_to_one,  ///< closest pairs first, each pose once
};

struct StampOptions {
  StampRule rule = StampRule::nearest;
  std::int64_t max_difference_ns = 10'000'000;  ///< inclusive; evo's default
};

struct IndexPair {
  std::size_t reference = 0, estimate = 0;
  bool operator==(const IndexPair&) const = default;
};

/// Index of the stamp nearest to `stamp_ns`, of two the earlier one. `stamps_ns` increase; there is one at
/// least.
std::size_t nearest_index(const std::vector<std::int64_t>& stamps_ns, std::int64_t stamp_ns);

/// Median time between neighbours; 0 of fewer than two.
std::int64_t median_period_ns(const std::vector<std::int64_t>& stamps_ns);

/// Of each stamp, increasing, whether it is a frame's after the one before: at most one and a half median
/// periods later. Of what comes after a hole, or first, it is not.
std::vector<bool> are_next_frames(const std::vector<std::int64_t>& stamps_ns);

/// Pairs of poses that belong to one time, in order of the reference. Stamps are strictly increasing. Of two
/// that are equally near the earlier one is taken; of lists of equal length the estimate counts as the
/// shorter (evo's choice).
std::vector<IndexPair> associate(const std::vector<std::int64_t>& reference_ns,
                                 const std::vector<std::int64_t>& estimate_ns, const StampOptions& options);

}  // namespace uniquadric
