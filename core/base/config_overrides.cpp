#include "core/base/config_overrides.h"

#include <fmt/format.h>

#include <charconv>
#include <span>

#include "core/base/error.h"
#include "core/base/yaml_bounds.h"

namespace uniquadric {
namespace {

// `a.b[2].c` in parts: a, b, [2, c.
std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> parts(1);
  for (const char c : key) {
    if (c == '.' || c == '[') parts.emplace_back();
    if (c != '.' && c != ']') parts.back() += c;
  }
  return parts;
}

class Setter {
 public:
  Setter(const ConfigOverride& value, const std::filesystem::path& file) : value_(value), file_(file) {}

  // Maps are made anew: one that an alias shares must not change elsewhere.
  YAML::Node set(const YAML::Node& node, std::span<const std::string> parts) const {
    if (parts.empty()) return read_value();
    if (parts.front().starts_with('[')) return set_item(node, parts);
    if (node.IsDefined() && !node.IsNull() && !node.IsMap())
      fail(fmt::format("there is no key '{}'", parts.front()));
    YAML::Node copy(YAML::NodeType::Map);
    bool is_found = false;
    for (const auto& pair : node) {
      const bool is_it = pair.first.IsScalar() && pair.first.Scalar() == parts.front();
      copy.force_insert(pair.first, is_it ? set(pair.second, parts.subspan(1)) : pair.second);
      is_found |= is_it;
    }
    if (!is_found) copy.force_insert(parts.front(), set(YAML::Node(), parts.subspan(1)));
    return copy;
  }

 private:
  YAML::Node set_item(const YAML::Node& list, std::span<const std::string> parts) const {
    const std::string_view digits = std::string_view(parts.front()).substr(1);
    std::size_t index = 0;
    const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), index);
    if (error != std::errc() || end != digits.data() + digits.size() || !list.IsSequence() ||
        index >= list.size())
      fail(fmt::format("there is no item [{}]", digits));
    YAML::Node copy(YAML::NodeType::Sequence);
    for (std::size_t i = 0; i < list.size(); ++i)
      copy.push_back(i == index ? set(list[i], parts.subspan(1)) : YAML::Node(list[i]));
    return copy;
  }

  YAML::Node read_value() const {
    require_bounded_yaml(value_.value, file_);
    try {
      return YAML::Load(value_.value);
    } catch (const YAML::Exception& e) {
      fail("malformed YAML: " + e.msg);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file_, fmt::format("set {}={}: {}", value_.key, value_.value, what));
  }

  const ConfigOverride& value_;
  const std::filesystem::path& file_;
};

}  // namespace

ConfigOverride parse_override(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0)
    throw InputError(fmt::format("--set {}: expected KEY=VALUE", text));
  return {text.substr(0, equals), text.substr(equals + 1)};
}

YAML::Node with_override(const YAML::Node& root, const ConfigOverride& value,
                         const std::filesystem::path& file) {
  return Setter(value, file).set(root, parts_of(value.key));
}

}  // namespace uniquadric
