#pragma once

#include <cstdint>

namespace uniquadric {

/// From one stamp to another [s].
inline double seconds(std::int64_t from_ns, std::int64_t to_ns) {
  return 1e-9 * static_cast<double>(to_ns - from_ns);
}

/// Rounded towards zero.
inline std::int64_t nanoseconds(double seconds) {
  return static_cast<std::int64_t>(1e9 * seconds);
}

}  // namespace uniquadric
