#include "core/base/config.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>

#include "core/base/config_overrides.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/text.h"
#include "core/base/yaml_bounds.h"

namespace uniquadric {
namespace {

// Whether the value at `name` is that at `key` or part of it.
bool is_within(const std::string& name, const std::string& key) {
  return name.starts_with(key) &&
         (name.size() == key.size() || name[key.size()] == '.' || name[key.size()] == '[');
}

// The value of another file that is at fault if there is no such key.
const ConfigOverride* override_that_made(const std::string& key,
                                         const std::vector<ConfigOverride>& overrides) {
  const auto made = [&](const ConfigOverride& value) {
    return !value.where.empty() && (is_within(key, value.key) || is_within(value.key, key));
  };
  const auto found = std::ranges::find_if(overrides, made);
  return found == overrides.end() ? nullptr : &*found;
}

}  // namespace

ConfigNode::ConfigNode(const YAML::Node& node, std::filesystem::path file, std::string name)
    : node_(std::make_shared<const YAML::Node>(node)),
      file_(std::move(file)),
      name_(std::move(name)),
      known_(std::make_shared<std::set<std::string>>()) {}

ConfigNode ConfigNode::load(const std::filesystem::path& path) {
  return parse(read_file(path, kYamlFile), path);
}

ConfigNode ConfigNode::parse(const std::string& text, const std::filesystem::path& name) {
  return parse(text, name, {});
}

ConfigNode ConfigNode::parse(const std::string& text, const std::filesystem::path& name,
                             const std::vector<ConfigOverride>& overrides) {
  require_bounded_yaml(text, name);
  try {
    const std::vector<YAML::Node> documents = YAML::LoadAll(text);
    if (documents.size() > 1)
      throw InputError(name, documents[1].Mark().line + 1, "a second YAML document; expected one");
    YAML::Node root = documents.empty() ? YAML::Node() : documents[0];
    for (const ConfigOverride& value : overrides) root.reset(with_override(root, value, name));
    ConfigNode node(root, name, "");
    node.overrides_ = std::make_shared<const std::vector<ConfigOverride>>(overrides);
    return node;
  } catch (const YAML::ParserException& e) {
    throw InputError(name, e.mark.line + 1, "malformed YAML: " + e.msg);
  } catch (const YAML::Exception& e) {
    throw InputError(name, std::string("malformed YAML: ") + e.what());
  }
}

ConfigNode ConfigNode::child(const YAML::Node& node, std::string name) const {
  ConfigNode child(node, file_, std::move(name));
  child.overrides_ = overrides_;
  return child;
}

// Whether the value, or one that it is part of, is none of the file.
bool ConfigNode::is_set() const {
  return std::ranges::any_of(*overrides_,
                             [&](const ConfigOverride& value) { return is_within(name_, value.key); });
}

// Throws with the place in another file that set this value, or one in this map: then either may be wrong.
void ConfigNode::blame_other_file(const std::string& what) const {
  for (const ConfigOverride& value : *overrides_)
    if (!value.where.empty() && is_within(name_, value.key))
      throw InputError(value.where + '.' + name_, what);
  if (node_->Mark().line >= 0) return;
  const std::string place = name_.empty() ? "" : '.' + name_;
  for (const ConfigOverride& value : *overrides_)
    if (!value.where.empty() && (name_.empty() || is_within(value.key, name_)))
      throw InputError(value.where + place, fmt::format("{} (in {})", what, file_.filename().string()));
}

std::string ConfigNode::place() const {
  return line() > 0 ? fmt::format("{}:{}: {}", file_.string(), line(), name_)
                    : fmt::format("{}: {}", file_.string(), name_);
}

int ConfigNode::line() const {
  return node_->Mark().line + 1;
}

void ConfigNode::fail(const std::string& what) const {
  const std::string message = name_.empty() ? what : name_ + ": " + what;
  blame_other_file(what);
  if (is_set()) throw InputError(file_, message + " (set, not the file's)");
  if (node_->Mark().line < 0) throw InputError(file_, message);
  throw InputError(file_, line(), message);
}

std::optional<ConfigNode> ConfigNode::find(const std::string& key) const {
  if (!node_->IsMap()) fail(fmt::format("expected a map with key '{}'", key));
  known_->insert(key);
  const YAML::Node value = (*node_)[key];
  if (!value.IsDefined()) return std::nullopt;
  return child(value, name_.empty() ? key : name_ + "." + key);
}

ConfigNode ConfigNode::at(const std::string& key) const {
  auto node = find(key);
  if (!node) fail(fmt::format("missing key '{}'", key));
  return *node;
}

std::vector<ConfigNode> ConfigNode::items() const {
  if (!node_->IsSequence()) fail("expected a list");
  std::vector<ConfigNode> result;
  for (std::size_t i = 0; i < node_->size(); ++i)
    result.push_back(child((*node_)[i], fmt::format("{}[{}]", name_, i)));
  return result;
}

std::vector<std::pair<std::string, ConfigNode>> ConfigNode::entries() const {
  if (!node_->IsMap()) fail("expected a map");
  std::vector<std::pair<std::string, ConfigNode>> result;
  for (const auto& pair : *node_) {
    const auto text = pair.first.Scalar();
    known_->insert(text);
    result.emplace_back(text, child(pair.second, name_.empty() ? text : name_ + "." + text));
  }
  return result;
}

bool ConfigNode::is_map() const {
  return node_->IsMap();
}
bool ConfigNode::is_sequence() const {
  return node_->IsSequence();
}
bool ConfigNode::is_scalar() const {
  return node_->IsScalar();
}

namespace {
template <typename T>
T convert(const ConfigNode& node, const YAML::Node& yaml, const char* kind) {
  T value;
  if (!yaml.IsScalar() || !YAML::convert<T>::decode(yaml, value)) node.fail(fmt::format("expected {}", kind));
  return value;
}
}  // namespace

template <>
bool ConfigNode::as<bool>() const {
  return convert<bool>(*this, *node_, "true or false");
}
template <>
int ConfigNode::as<int>() const {
  return convert<int>(*this, *node_, "an integer");
}
template <>
std::int64_t ConfigNode::as<std::int64_t>() const {
  return convert<std::int64_t>(*this, *node_, "an integer");
}
template <>
std::uint64_t ConfigNode::as<std::uint64_t>() const {
  if (node_->IsScalar() && node_->Scalar().starts_with('-')) fail("expected an integer of at least 0");
  return convert<std::uint64_t>(*this, *node_, "an integer of at least 0");
}
template <>
std::string ConfigNode::as<std::string>() const {
  return convert<std::string>(*this, *node_, "a text");
}
template <>
double ConfigNode::as<double>() const {
  const double value = convert<double>(*this, *node_, "a number");
  if (!std::isfinite(value)) fail("expected a finite number");
  return value;
}
template <>
std::vector<double> ConfigNode::as<std::vector<double>>() const {
  std::vector<double> values;
  for (const ConfigNode& item : items()) values.push_back(item.as<double>());
  return values;
}
template <>
Eigen::Vector3d ConfigNode::as<Eigen::Vector3d>() const {
  const auto values = as<std::vector<double>>();
  if (values.size() != 3) fail(fmt::format("expected 3 numbers, found {}", values.size()));
  return {values[0], values[1], values[2]};
}

double ConfigNode::positive(const std::string& key) const {
  const ConfigNode node = at(key);
  const double value = node.as<double>();
  if (value <= 0) node.fail(fmt::format("expected a number greater than 0, found {}", value));
  return value;
}

double ConfigNode::positive(const std::string& key, double fallback) const {
  return has(key) ? positive(key) : fallback;
}

std::string ConfigNode::yaml() const {
  YAML::Emitter out;
  out.SetMapFormat(YAML::Flow);
  out.SetSeqFormat(YAML::Flow);
  out << *node_;
  return out.c_str();
}

std::string ConfigNode::choice(const std::string& key, const std::vector<std::string>& choices,
                               const std::string& fallback) const {
  const auto node = find(key);
  if (!node) return fallback;
  const auto value = node->as<std::string>();
  if (std::find(choices.begin(), choices.end(), value) == choices.end())
    node->fail(fmt::format("'{}' is none of: {}", value, fmt::join(choices, ", ")));
  return value;
}

std::string ConfigNode::name(const std::string& key) const {
  const ConfigNode node = at(key);
  const auto text = node.as<std::string>();
  if (!is_plain_name(text)) node.fail(kPlainNameExpected);
  return text;
}

std::string ConfigNode::name(const std::string& key, const std::string& fallback) const {
  return has(key) ? name(key) : fallback;
}

void ConfigNode::refuse_unknown_keys() const {
  if (!node_->IsMap()) fail("expected a map");
  std::set<std::string> seen;
  for (const auto& pair : *node_) {
    const auto text = pair.first.IsScalar() ? pair.first.Scalar() : std::string("?");
    const int at_line = pair.first.Mark().line + 1;
    const std::string shown = name_.empty() ? text : name_ + "." + text;
    if (!seen.insert(text).second)
      throw InputError(file_, at_line, fmt::format("key '{}' stands twice", shown));
    if (known_->contains(text)) continue;
    const std::string what = fmt::format("unknown key '{}' (known: {})", shown, fmt::join(*known_, ", "));
    if (const ConfigOverride* value = override_that_made(shown, *overrides_))
      throw InputError(value->where + '.' + value->key, what);
    if (is_set() || at_line < 1) throw InputError(file_, what);
    throw InputError(file_, at_line, what);
  }
}

}  // namespace uniquadric
