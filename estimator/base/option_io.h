#pragma once

#include <fmt/format.h>

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/config.h"
#include "core/base/text.h"

namespace uniquadric {

template <typename E>
using Choices = std::vector<std::pair<const char*, E>>;

inline constexpr int kMostIterations = 1'000'000;  // of any option: hours, a typing error

/// What a number greater than 0 may be: beyond, squares and counts made of it are no numbers any more.
struct OptionRange {
  double low = 1e-9, high = 1e9;
};
/// What a standard deviation may be: no sensor and no model is better, and what is worse says nothing.
inline constexpr OptionRange kSigma_px{0.01, 1000}, kSigma_m{1e-5, 10}, kSigma_rad{1e-6, 10},
    kSigmaOfRatio{1e-4, 1000};

/// Fills option structs from a YAML map. Reader and writer have the same calls, so that one function per
/// struct names its keys for both.
class OptionReader {
 public:
  explicit OptionReader(ConfigNode node) : node_(std::move(node)) {}

  void text(const char* key, std::string& value) { value = node_.get<std::string>(key, value); }
  void flag(const char* key, bool& value) { value = node_.get<bool>(key, value); }

  /// A number in [low, high].
  template <typename T>
  void number(const char* key, T& value, T low, T high = std::numeric_limits<T>::max()) {
    value = node_.get<T>(key, value);
    if (value < low || value > high)
      node_.at(key).fail(high == std::numeric_limits<T>::max()
                             ? fmt::format("expected at least {}, found {}", low, value)
                             : fmt::format("expected {} to {}, found {}", low, high, value));
  }

  /// A length or another number greater than 0.
  void positive(const char* key, double& value, const OptionRange& range = {}) {
    value = node_.positive(key, value);
    number(key, value, range.low, range.high);
  }
  /// The same, where nothing is said otherwise.
  void positive(const char* key, std::optional<double>& value, const OptionRange& range = {}) {
    if (!node_.find(key)) return;
    value = node_.positive(key);
    number(key, *value, range.low, range.high);
  }

  template <typename E>
  void choice(const char* key, E& value, const Choices<E>& choices) {
    std::vector<std::string> names;
    for (const auto& [name, meaning] : choices) names.emplace_back(name);
    const std::string name = node_.choice(key, names, "");
    for (const auto& [known, meaning] : choices)
      if (name == known) value = meaning;
  }

  template <typename Visit>
  void section(const char* key, const Visit& visit) {
    const auto node = node_.find(key);
    if (!node) return;
    OptionReader inner(*node);
    visit(inner);
    inner.node_.refuse_unknown_keys();
  }

 private:
  ConfigNode node_;
};

/// Writes option structs as a YAML map.
class OptionWriter {
 public:
  void text(const char* key, const std::string& value) {
    line(key, yaml_quoted(value));
    texts_.push_back(value);
  }
  void flag(const char* key, bool value) { line(key, value ? "true" : "false"); }
  template <typename T>
  void number(const char* key, T value, T /*low*/, T /*high*/ = T{}) {
    line(key, fmt::format("{}", value));
  }
  void positive(const char* key, double value, const OptionRange& /*range*/ = {}) {
    line(key, fmt::format("{}", value));
  }
  void positive(const char* key, const std::optional<double>& value, const OptionRange& /*range*/ = {}) {
    if (value) positive(key, *value);
  }
  template <typename E>
  void choice(const char* key, E value, const Choices<E>& choices) {
    for (const auto& [name, meaning] : choices)
      if (meaning == value) line(key, name);
  }
  template <typename Visit>
  void section(const char* key, const Visit& visit) {
    yaml_ += fmt::format("{}{}:\n", indent_, key);
    indent_ += "  ";
    visit(*this);
    indent_.resize(indent_.size() - 2);
  }
  const std::string& yaml() const { return yaml_; }
  const std::vector<std::string>& texts() const { return texts_; }  ///< all values of text(): files, mostly

 private:
  void line(const char* key, const std::string& value) {
    yaml_ += fmt::format("{}{}: {}\n", indent_, key, value);
  }
  std::string yaml_, indent_;
  std::vector<std::string> texts_;
};

}  // namespace uniquadric
