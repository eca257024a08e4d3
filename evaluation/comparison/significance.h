#pragma once

#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

namespace uniquadric {

/// What a sign-flip test says of a sum of paired differences.
struct SignFlip {
  double p_above = 1;         ///< chance of a sum at least as great when each difference's sign is a coin's
  double p_below = 1;         ///< of one at least as small
  bool exact = true;          ///< all flips were counted; else drawn
  std::size_t differing = 0;  ///< differences other than 0, which alone count
};

constexpr std::size_t kMostExactPairs = 20;      // SPEC: 2^20 flips are counted in milliseconds
constexpr std::size_t kSignFlipDraws = 100'000;  // SPEC: the standard error of p = 0.05 is 0.0007

/// One-sided sign-flip tests of the sum of `differences` (weights in them), both sides. Exact up to 20
/// differences other than 0; else 100,000 draws from the random stream of (seed 0, `stream`), the flip that
/// was observed counted as one more, so that p is never 0 and the test keeps its level.
SignFlip sign_flip(const std::vector<double>& differences, std::string_view stream);

/// The least p of a sign-flip test of `pairs` differences: every one of them on the same side.
double least_p(std::size_t pairs);

/// The smallest shift s for which sign_flip of `differences` + s * `weights` has p_above <= `p`; nothing when
/// so few differences cannot have so small a p. `weights` are positive, one for each difference.
std::optional<double> provable_shift(const std::vector<double>& differences,
                                     const std::vector<double>& weights, double p, std::string_view stream);

/// Holm's step-down correction: `p <= alpha` of the results holds the chance of any false rejection among all
/// under alpha. In the order of the input.
std::vector<double> holm(const std::vector<double>& p);

/// The greatest p that Holm's correction lets reject at `alpha` beside tests whose p are `others`.
double holm_level(std::vector<double> others, double alpha);

/// Tarone's level: tests whose least possible p is above it prove nothing and need not be corrected for. It
/// is alpha / K for the smallest K that is at least the number of tests with a `least` p up to alpha / K.
double tarone_level(const std::vector<double>& least, double alpha);

}  // namespace uniquadric
