#include "core/base/error.h"

#include <fmt/format.h>

namespace uniquadric {
namespace {
std::string shown(const std::filesystem::path& path) {
  return path.empty() ? "(empty name)" : path.string();
}
}  // namespace

InputError::InputError(const std::filesystem::path& path, const std::string& what)
    : std::runtime_error(fmt::format("{}: {}", shown(path), what)) {}

InputError::InputError(const std::filesystem::path& path, int line, const std::string& what)
    : std::runtime_error(fmt::format("{}:{}: {}", shown(path), line, what)) {}

}  // namespace uniquadric
