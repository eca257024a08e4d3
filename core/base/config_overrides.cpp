#include "core/base/config_overrides.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <span>

#include "core/base/error.h"
#include "core/base/yaml_bounds.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostParts = 64;  // ours: as deep as files may be nested

// `a.b[2].c` in parts: a, b, [2, c. Empty: it is none of a key's form.
std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> parts;
  std::size_t at = 0;
  while (at < key.size()) {
    const bool is_index = key[at] == '[';
    if (!is_index && at > 0 && key[at++] != '.') return {};
    const std::size_t end = std::min(key.find_first_of(is_index ? "]" : ".[]", at), key.size());
    const std::size_t begin = at;
    at = is_index ? end + 1 : end;
    if (end == begin + (is_index ? 1 : 0) || at > key.size() || parts.size() == kMostParts) return {};
    parts.push_back(key.substr(begin, end - begin));
  }
  return parts.empty() || parts.front().starts_with('[') ? std::vector<std::string>{} : parts;
}

class Setter {
 public:
  Setter(const ConfigOverride& value, const std::filesystem::path& file) : value_(value), file_(file) {}

  YAML::Node set(const YAML::Node& root) const {
    const std::vector<std::string> parts = parts_of(value_.key);
    if (parts.empty())
      fail(fmt::format("expected a key such as lidar.method or objects[0].name, of at most {} parts",
                       kMostParts));
    return set(root, parts);
  }

 private:
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
    require_bounded_yaml(value_.value, fmt::format("{}: set {}", file_.string(), value_.key));
    try {
      const std::vector<YAML::Node> documents = YAML::LoadAll(value_.value);
      if (documents.size() > 1) fail("expected one value");
      return documents.empty() ? YAML::Node() : documents.front();
    } catch (const YAML::Exception& e) {
      fail("malformed YAML: " + e.msg);
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    constexpr std::size_t kMostShown = 100;  // so that the reason stays in sight
    if (!value_.where.empty()) throw InputError(value_.where + '.' + value_.key.substr(0, kMostShown), what);
    throw InputError(file_, fmt::format("set {}={}: {}", value_.key.substr(0, kMostShown),
                                        value_.value.substr(0, kMostShown), what));
  }

  const ConfigOverride& value_;
  const std::filesystem::path& file_;
};

}  // namespace

std::vector<ConfigOverride> parse_overrides(const std::vector<std::string>& texts) {
  std::vector<ConfigOverride> overrides;
  for (const std::string& text : texts) {
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0)
      throw InputError(fmt::format("--set {}: expected KEY=VALUE", text));
    overrides.push_back({text.substr(0, equals), text.substr(equals + 1)});
  }
  return overrides;
}

YAML::Node with_override(const YAML::Node& root, const ConfigOverride& value,
                         const std::filesystem::path& file) {
  return Setter(value, file).set(root);
}

}  // namespace uniquadric
