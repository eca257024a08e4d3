#include "core/base/warning.h"

#include <fmt/format.h>

#include <atomic>
#include <cstdio>

namespace uniquadric {
namespace {

std::atomic<int> given = 0;

}  // namespace

void warn(const std::string& text) {
  ++given;
  fmt::print(stderr, "warning: {}\n", text);
}

int warnings_given() {
  return given;
}

}  // namespace uniquadric
