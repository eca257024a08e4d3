#pragma once

#include <Eigen/Core>
#include <filesystem>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace YAML {
class Node;
}

namespace uniquadric {

struct ConfigOverride;

/// A node of a YAML file (within yaml_bounds.h) that refuses what it does not know. Every access that fails
/// throws InputError with file and line. Read all keys of a map, then call `refuse_unknown_keys()`.
class ConfigNode {
 public:
  static ConfigNode load(const std::filesystem::path& path);
  static ConfigNode parse(const std::string& text, const std::filesystem::path& name);
  /// With values set that need not be the file's (config_overrides.h).
  static ConfigNode parse(const std::string& text, const std::filesystem::path& name,
                          const std::vector<ConfigOverride>& overrides);

  bool has(const std::string& key) const { return find(key).has_value(); }
  /// The value of a key of this map; nothing when the key is absent.
  std::optional<ConfigNode> find(const std::string& key) const;
  /// The value of a required key.
  ConfigNode at(const std::string& key) const;
  /// The items of this sequence.
  std::vector<ConfigNode> items() const;
  /// The pairs of a map whose keys are the user's (all count as known).
  std::vector<std::pair<std::string, ConfigNode>> entries() const;
  bool is_map() const;
  bool is_sequence() const;
  bool is_scalar() const;

  /// This scalar (or list of numbers) as T: bool, int, std::int64_t, std::uint64_t, double (finite),
  /// std::string, std::vector<double>, Eigen::Vector3d.
  template <typename T>
  T as() const;
  template <typename T>
  T get(const std::string& key) const {
    return at(key).as<T>();
  }
  template <typename T>
  T get(const std::string& key, T fallback) const {
    const auto node = find(key);
    return node ? node->as<T>() : fallback;
  }
  /// A number that must be greater than zero.
  double positive(const std::string& key) const;
  double positive(const std::string& key, double fallback) const;
  /// This value as YAML in one line.
  std::string yaml() const;
  /// One of `choices`.
  std::string choice(const std::string& key, const std::vector<std::string>& choices,
                     const std::string& fallback) const;

  /// A text that can be a name in CSV files and folders (is_plain_name).
  std::string name(const std::string& key) const;
  std::string name(const std::string& key, const std::string& fallback) const;

  /// Throws for keys that were never asked for, and for keys that stand twice.
  void refuse_unknown_keys() const;
  /// Throws InputError with this node's file and line.
  [[noreturn]] void fail(const std::string& what) const;
  const std::filesystem::path& file() const { return file_; }
  /// The dotted path of keys that leads here, as messages have it; of the whole file empty.
  const std::string& key_path() const { return name_; }
  int line() const;
  /// Where this value stands, as messages begin: file, line where there is one, and dotted path of keys.
  std::string place() const;

 private:
  ConfigNode(const YAML::Node& node, std::filesystem::path file, std::string name);
  ConfigNode child(const YAML::Node& node, std::string name) const;
  bool is_set() const;
  void blame_other_file(const std::string& what) const;
  std::shared_ptr<const YAML::Node> node_;
  std::filesystem::path file_;
  std::string name_;  // dotted path of keys, for messages
  std::shared_ptr<std::set<std::string>> known_;
  std::shared_ptr<const std::vector<ConfigOverride>> overrides_;
};

template <>
bool ConfigNode::as<bool>() const;
template <>
int ConfigNode::as<int>() const;
template <>
std::int64_t ConfigNode::as<std::int64_t>() const;
template <>
std::uint64_t ConfigNode::as<std::uint64_t>() const;
template <>
double ConfigNode::as<double>() const;
template <>
std::string ConfigNode::as<std::string>() const;
template <>
std::vector<double> ConfigNode::as<std::vector<double>>() const;
template <>
Eigen::Vector3d ConfigNode::as<Eigen::Vector3d>() const;

}  // namespace uniquadric
