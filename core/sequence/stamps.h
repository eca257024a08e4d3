#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

namespace uniquadric {

/// Of a stamp that is read: the year 2112 and as far before 1970. Differences of two fit into 64 bits.
inline constexpr std::int64_t kMostStamp_ns = 4'500'000'000'000'000'000;

/// A stamp in whole nanoseconds; nothing for other texts and beyond kMostStamp_ns.
std::optional<std::int64_t> parse_stamp_of_ns(std::string_view text);

/// The stamps of frames, scans, samples or poses.
template <typename Stamped>
std::vector<std::int64_t> stamps_of(const std::vector<Stamped>& list) {
  std::vector<std::int64_t> stamps_ns;
  stamps_ns.reserve(list.size());
  for (const Stamped& item : list) stamps_ns.push_back(item.stamp_ns);
  return stamps_ns;
}

}  // namespace uniquadric
