#include "simulator/noise/normals.h"

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace uniquadric {
namespace {

constexpr int kCellBits = 12;
constexpr int kCells = 1 << kCellBits;
constexpr int kPlaceBits = 16 - kCellBits;

// Edges of the cells; the first and the last stand at the finite side of theirs.
std::array<float, kCells + 1> make_edges() {
  std::array<float, kCells + 1> edges{};
  for (int i = 1; i < kCells; ++i) edges[i] = static_cast<float>(normal_quantile(i / double{kCells}));
  edges[0] = edges[1];
  edges[kCells] = edges[kCells - 1];
  return edges;
}

// A normal number given that it is greater than `start`.
double tail_normal(RandomStream& stream, double start) {
  for (;;) {
    const double x = std::sqrt(start * start - 2 * std::log(stream.uniform()));
    if (x * stream.uniform() < start) return x;
  }
}

}  // namespace

double normal_cdf(double x) {
  return 0.5 * std::erfc(-x / std::numbers::sqrt2);
}

double normal_quantile(double p) {
  double low = -40, high = 40;    // beyond, the distribution function is 0 or 1 in double
  for (int i = 0; i < 64; ++i) {  // bisection to the last bit: the tables are made once
    const double middle = (low + high) / 2;
    (normal_cdf(middle) < p ? low : high) = middle;
  }
  return (low + high) / 2;
}

void fill_normals(RandomStream& stream, std::span<float> values) {
  static const std::array<float, kCells + 1> edges = make_edges();
  std::vector<std::uint32_t> bits((values.size() + 1) / 2);
  stream.fill(bits);
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::uint32_t draw = bits[i / 2] >> (i % 2 ? 16 : 0) & 0xffff, cell = draw >> kPlaceBits;
    const float place =
        (static_cast<float>(draw & ((1u << kPlaceBits) - 1)) + 0.5f) * (1.0f / (1u << kPlaceBits));
    values[i] = edges[cell] + (edges[cell + 1] - edges[cell]) * place;
    if (cell == 0 || cell == kCells - 1) {
      const double tail = tail_normal(stream, edges[kCells - 1]);
      values[i] = static_cast<float>(cell == 0 ? -tail : tail);
    }
  }
}

}  // namespace uniquadric
