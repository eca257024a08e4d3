#include "evaluation/metrics/figures.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "core/base/version.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr int kSchema = 1;

struct AsText {
  std::string operator()(const std::optional<double>& value) const {
    return value ? fmt::format("{:.6g}", *value) : "-";
  }
  std::string operator()(std::uint64_t value) const { return fmt::format("{}", value); }
  std::string operator()(const std::string& value) const { return value; }
};

struct AsJson {
  json operator()(const std::optional<double>& value) const { return value ? json(*value) : json(); }
  json operator()(std::uint64_t value) const { return value; }
  json operator()(const std::string& value) const { return value; }
};

}  // namespace

std::string figures_text(const Figures& figures) {
  std::string text;
  for (const Figure& f : figures)
    text += fmt::format("{:<26}{:>14}\n", f.name, std::visit(AsText{}, f.value));
  return text;
}

std::string figures_json(const Figures& figures) {
  json root = {{"schema", kSchema}, {"program", kProgram}};
  for (const Figure& f : figures) root[f.name] = std::visit(AsJson{}, f.value);
  return root.dump(2) + "\n";
}

std::optional<double> share(std::uint64_t part, std::uint64_t whole) {
  if (whole == 0) return std::nullopt;
  return static_cast<double>(part) / static_cast<double>(whole);
}

}  // namespace uniquadric
