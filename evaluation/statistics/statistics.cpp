#include "evaluation/statistics/statistics.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace uniquadric {

std::optional<Statistics> statistics(const std::vector<double>& values) {
  if (values.empty()) return std::nullopt;
  Statistics result;
  result.n = values.size();
  const double n = static_cast<double>(values.size());
  double sum = 0;
  for (const double value : values) {
    assert(std::isfinite(value));
    sum += value;
    result.sse += value * value;
  }
  result.rmse = std::sqrt(result.sse / n);
  const auto [min, max] = std::minmax_element(values.begin(), values.end());
  result.min = *min;
  result.max = *max;
  // Rounding may carry the mean of equal values past them.
  result.mean = std::clamp(sum / n, result.min, result.max);
  double squares = 0;  // second pass: no cancellation for a small spread about a large mean
  for (const double value : values) squares += (value - result.mean) * (value - result.mean);
  result.std = std::sqrt(squares / n);
  std::vector<double> halves = values;
  const auto middle = halves.begin() + std::ssize(halves) / 2;
  std::nth_element(halves.begin(), middle, halves.end());
  result.median =
      halves.size() % 2 == 1 ? *middle : (*std::max_element(halves.begin(), middle) + *middle) / 2;
  return result;
}

double interpolated_quantile(std::vector<double> values, double q) {
  assert(!values.empty() && q >= 0 && q <= 1);
  std::sort(values.begin(), values.end());
  const double at = q * static_cast<double>(values.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const std::size_t above = std::min(below + 1, values.size() - 1);
  return std::lerp(values[below], values[above], at - static_cast<double>(below));
}

}  // namespace uniquadric
