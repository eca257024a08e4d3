#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace YAML {
class Node;
}

namespace uniquadric {

/// A value that takes the place of one in a YAML file.
struct ConfigOverride {
  std::string key;    ///< as messages name values: `frames`, `lidar.method`, `objects[0].name`
  std::string value;  ///< YAML
  /// Of one that another file sets: the place there as messages begin, `bench.yaml:3: scenes[0].set`. Empty:
  /// the command line's.
  std::string where{};
};

/// Reads texts of the form KEY=VALUE; throws InputError for any other.
std::vector<ConfigOverride> parse_overrides(const std::vector<std::string>& texts);

/// A copy of `root` with the value; maps on the way to it are made where there are none. Throws InputError
/// with `file` for a key that leads through a scalar or past a list's end or has more than 64 parts, and for
/// a value that is no single YAML document.
YAML::Node with_override(const YAML::Node& root, const ConfigOverride& value,
                         const std::filesystem::path& file);

}  // namespace uniquadric
