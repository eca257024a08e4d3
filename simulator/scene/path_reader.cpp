#include "simulator/scene/path_reader.h"

#include <fmt/format.h>

#include <cstdlib>
#include <string>

#include "core/base/config.h"

namespace uniquadric {

namespace fs = std::filesystem;

fs::path resolve_path(const ConfigNode& node) {
  auto text = node.as<std::string>();
  const fs::path folder = node.file().parent_path();
  if (const auto begin = text.find("${"); begin != text.npos) {
    const auto end = text.find('}', begin);
    if (end == text.npos) node.fail("'${' without '}'");
    const std::string variable = text.substr(begin + 2, end - begin - 2);
    const char* value = std::getenv(variable.c_str());
    if (!value && variable != "UNIQUADRIC_DATA")
      node.fail(fmt::format("environment variable {} is not set", variable));
    text.replace(begin, end + 1 - begin, value ? value : "../../shared/data");
  }
  return (folder / text).lexically_normal();
}

fs::path find_file(const ConfigNode& node) {
  const fs::path path = resolve_path(node);
  std::error_code too_long;
  if (fs::is_regular_file(path, too_long)) return path;
  if (fs::is_directory(path, too_long)) node.fail(fmt::format("is a folder: {}", path.string()));
  const bool by_default =
      node.as<std::string>().starts_with("${UNIQUADRIC_DATA}") && !std::getenv("UNIQUADRIC_DATA");
  node.fail(fmt::format("no such file: {}{}", path.string(),
                        by_default ? " (set UNIQUADRIC_DATA to the folder that holds the data)" : ""));
}

}  // namespace uniquadric
