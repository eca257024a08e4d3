#include "core/base/error.h"

#include <fmt/format.h>

namespace uniquadric {
namespace {
std::string shown(const std::filesystem::path& path) {
  return path.empty() ? "(empty name)" : path.string();
}

// Bytes of a bad file do not reach the terminal as they are, nor do they end the message, nor fill the
// screen.
std::string printable(const std::string& text) {
  constexpr std::size_t kMostShown = 1000;
  if (text.size() > kMostShown) return printable(text.substr(0, kMostShown)) + "...";
  std::string result;
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7f)
      result += fmt::format("\\x{:02x}", byte);
    else
      result += c;
  }
  return result;
}

}  // namespace

InputError::InputError(const std::filesystem::path& path, const std::string& what)
    : std::runtime_error(printable(fmt::format("{}: {}", shown(path), what))) {}

InputError::InputError(const std::filesystem::path& path, int line, const std::string& what)
    : std::runtime_error(printable(fmt::format("{}:{}: {}", shown(path), line, what))) {}

}  // namespace uniquadric
