#include "evaluation/report/svg_colours.h"

#include <charconv>

namespace uniquadric {

std::optional<Rgb> rgb_of(const std::string& hex) {
  int value = 0;
  const char* const end = hex.data() + hex.size();
  if (hex.size() != 7 || hex[0] != '#' || hex[1] == '-') return std::nullopt;
  if (std::from_chars(hex.data() + 1, end, value, 16).ptr != end) return std::nullopt;
  return Rgb{value >> 16, value >> 8 & 0xff, value & 0xff};
}

}  // namespace uniquadric
