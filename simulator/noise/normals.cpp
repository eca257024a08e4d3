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

// The normal numbers of a cell's draws: start, and from one draw to the next.
struct Cell {
  float start = 0, step = 0;
};

struct Cells {
  std::array<Cell, kCells> cell;
  float tail_start = 0;  // beyond it, on either side, there is no last number
};

// Edges each by Newton's method from the one before; the second half mirrors the first.
Cells make_cells() {
  Cells cells;
  double x = normal_quantile(1.0 / kCells);
  cells.tail_start = static_cast<float>(-x);
  for (int i = 1; i < kCells / 2; ++i) {
    const double low = x, p = (i + 1) / double{kCells};
    for (int k = 0; k < 8; ++k)
      x += (p - normal_cdf(x)) * std::sqrt(2 * std::numbers::pi) * std::exp(x * x / 2);
    const double step = (x - low) / (1 << kPlaceBits);
    cells.cell[i] = {static_cast<float>(low + step / 2), static_cast<float>(step)};
    cells.cell[kCells - 1 - i] = {static_cast<float>(-x + step / 2), static_cast<float>(step)};
  }
  return cells;
}

float normal_of(const Cells& cells, std::uint32_t draw) {
  const Cell& cell = cells.cell[draw >> kPlaceBits];
  return cell.start + cell.step * static_cast<float>(static_cast<int>(draw & ((1u << kPlaceBits) - 1)));
}

// Whether a draw falls into the first or the last cell.
bool is_tail(std::uint32_t draw) {
  return ((draw + (1u << kPlaceBits)) & 0xffff) < 2u << kPlaceBits;
}

// Whether one of that many words holds such a draw: looked at without a branch.
constexpr std::size_t kRun = 16;
bool has_tail(const std::uint32_t* words) {
  std::uint32_t found = 0;
  for (std::size_t i = 0; i < kRun; ++i) found |= is_tail(words[i] & 0xffff) | is_tail(words[i] >> 16);
  return found != 0;
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
  static const Cells cells = make_cells();
  std::vector<std::uint32_t> bits((values.size() + 1) / 2);
  stream.fill(bits);
  for (std::size_t i = 0; i + 1 < values.size(); i += 2) {
    values[i] = normal_of(cells, bits[i / 2] & 0xffff);
    values[i + 1] = normal_of(cells, bits[i / 2] >> 16);
  }
  if (values.size() % 2 == 1) values.back() = normal_of(cells, bits.back() & 0xffff);
  for (std::size_t i = 0; i < values.size(); ++i) {  // apart: rare, and they go on drawing
    if (i % (2 * kRun) == 0 && i / 2 + kRun <= bits.size() && !has_tail(&bits[i / 2])) {
      i += 2 * kRun - 1;
      continue;
    }
    const std::uint32_t draw = bits[i / 2] >> (i % 2 ? 16 : 0) & 0xffff;
    if (!is_tail(draw)) continue;
    const double tail = tail_normal(stream, cells.tail_start);
    values[i] = static_cast<float>(draw >> kPlaceBits == 0 ? -tail : tail);
  }
}

}  // namespace uniquadric
