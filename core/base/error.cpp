#include "core/base/error.h"

#include <fmt/format.h>

namespace uniquadric {

InputError::InputError(const std::filesystem::path& path, const std::string& what)
    : std::runtime_error(fmt::format("{}: {}", path.string(), what)) {}

InputError::InputError(const std::filesystem::path& path, int line, const std::string& what)
    : std::runtime_error(fmt::format("{}:{}: {}", path.string(), line, what)) {}

}  // namespace uniquadric
