#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <vector>

namespace uniquadric {

constexpr double kSigmas = 5;  ///< a sound sampler fails a test of its moments once in two million runs

inline double count_of(const std::vector<double>& x) {
  return static_cast<double>(x.size());
}

inline double mean(const std::vector<double>& x) {
  return std::accumulate(x.begin(), x.end(), 0.0) / count_of(x);
}

inline double deviation(const std::vector<double>& x) {
  const double m = mean(x);
  return std::sqrt(std::accumulate(x.begin(), x.end(), 0.0,
                                   [m](double sum, double v) { return sum + (v - m) * (v - m); }) /
                   count_of(x));
}

/// sum (n - expected)^2 / expected must stay below its mean + kSigmas standard deviations
inline void expect_chi_square(const std::vector<double>& counts, const std::vector<double>& expected) {
  double chi_square = 0;
  for (std::size_t i = 0; i < counts.size(); ++i)
    chi_square += (counts[i] - expected[i]) * (counts[i] - expected[i]) / expected[i];
  const double freedom = static_cast<double>(counts.size() - 1);
  EXPECT_LT(chi_square, freedom + kSigmas * std::sqrt(2 * freedom));
  EXPECT_GT(chi_square, freedom - kSigmas * std::sqrt(2 * freedom));  // too even is not random either
}

}  // namespace uniquadric
