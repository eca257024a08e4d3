#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace uniquadric {

/// A figure of a metric over files. Nothing stands for one that is not defined: the error of no pixel.
struct Figure {
  std::string name;  ///< with its unit
  std::variant<std::optional<double>, std::uint64_t, std::string> value;
};
using Figures = std::vector<Figure>;

/// A line a figure, in their order, undefined ones as `-`.
std::string figures_text(const Figures& figures);
/// A JSON object with schema and program: keys sorted, doubles that read back the same, undefined ones null.
std::string figures_json(const Figures& figures);

/// part / whole; nothing of nothing.
std::optional<double> share(std::uint64_t part, std::uint64_t whole);

}  // namespace uniquadric
