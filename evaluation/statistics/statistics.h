#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace uniquadric {

/// The summary that every error is reported by (evo's): `sse` is the sum of squares, `std` divides by n (ddof
/// 0), the median of an even number of values is the mean of the middle two. Units are the values' own.
struct Statistics {
  double rmse = 0, mean = 0, median = 0, std = 0, min = 0, max = 0, sse = 0;
  std::size_t n = 0;
};

/// Nothing when there are no values. Values must be finite.
std::optional<Statistics> statistics(const std::vector<double>& values);

/// The value that a share `q` in [0, 1] of the values is below, linear between two of them (R's type 7).
/// Needs a value.
double interpolated_quantile(std::vector<double> values, double q);

}  // namespace uniquadric
