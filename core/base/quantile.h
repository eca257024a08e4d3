#pragma once

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <vector>

namespace uniquadric {

/// A normal distribution's standard deviation over its median absolute deviation.
inline constexpr double kMadToSigma = 1.4826;

/// The value at the rank nearest to q (n - 1), halves upwards; at least one value, q in [0, 1].
inline double quantile(std::vector<double> values, double q) {
  const auto at = static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + at, values.end());
  return values[static_cast<std::size_t>(at)];
}

/// The middle value, of two the larger; at least one value.
template <typename T>
T upper_median(std::vector<T> values) {
  const auto middle = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace uniquadric
