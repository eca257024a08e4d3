#include "evaluation/iou/count_inside_parts.h"

namespace uniquadric {
namespace {

// Compiled once for each set of instructions, into the functions below.
[[gnu::always_inline]] inline std::int64_t count(const double* x, const double* y, const double* z,
                                                 std::int64_t n, const double* center,
                                                 const double* semi_axes) {
  const double cx = center[0], cy = center[1], cz = center[2];
  const double ax = semi_axes[0], ay = semi_axes[1], az = semi_axes[2];
  std::int64_t inside = 0;
  for (std::int64_t i = 0; i < n; ++i) {
    const double dx = cx + ax * x[i], dy = cy + ay * y[i], dz = cz + az * z[i];
    inside += dx * dx + (dy * dy + dz * dz) <= 1 ? 1 : 0;
  }
  return inside;
}

#if defined(__x86_64__)
[[gnu::target("avx2")]] std::int64_t count_by_four(const double* x, const double* y, const double* z,
                                                   std::int64_t n, const double* center,
                                                   const double* semi_axes) {
  return count(x, y, z, n, center, semi_axes);
}
#endif

}  // namespace

std::int64_t count_inside_baseline(const double* x, const double* y, const double* z, std::int64_t n,
                                   const double* center, const double* semi_axes) {
  return count(x, y, z, n, center, semi_axes);
}

CountInside count_inside_avx2() {
#if defined(__x86_64__)
  return __builtin_cpu_supports("avx2") ? count_by_four : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace uniquadric
