#pragma once

#include <cstdint>

namespace uniquadric {

/// How many of n points, moved to center + semi_axes * (x, y, z) axis by axis, lie in the unit ball.
/// `center` and `semi_axes` have three values.
using CountInside = std::int64_t (*)(const double* x, const double* y, const double* z, std::int64_t n,
                                     const double* center, const double* semi_axes);

/// With the instructions that every machine of the kind has. The same operations in the same order as the
/// other, nothing contracted: the same count.
std::int64_t count_inside_baseline(const double* x, const double* y, const double* z, std::int64_t n,
                                   const double* center, const double* semi_axes);

/// With AVX2, on four points at once; null where the machine has none.
CountInside count_inside_avx2();

}  // namespace uniquadric
