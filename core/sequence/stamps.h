#pragma once

#include <cstdint>
#include <vector>

namespace uniquadric {

/// The stamps of frames, scans, samples or poses.
template <typename Stamped>
std::vector<std::int64_t> stamps_of(const std::vector<Stamped>& list) {
  std::vector<std::int64_t> stamps_ns;
  for (const Stamped& item : list) stamps_ns.push_back(item.stamp_ns);
  return stamps_ns;
}

}  // namespace uniquadric
