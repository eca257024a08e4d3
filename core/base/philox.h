#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace uniquadric {

/// One block of Philox4x32-10 (Salmon et al., SC 2011).
std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key);

inline constexpr std::size_t kPhiloxLanes = 16;

/// kPhiloxLanes successive blocks, 4 numbers each: those of philox() for counter[0], counter[0] + 1, ...
void philox_lanes(const std::array<std::uint32_t, 4>& counter, const std::array<std::uint32_t, 2>& key,
                  std::uint32_t* values);

}  // namespace uniquadric
