#pragma once
#include <fmt/format.h>
#include <cstdlib>
#include <cstdio>
namespace uniquadric {
template <typename... T>
void debug(fmt::format_string<T...> f, T&&... args) {
  static const bool on = std::getenv("PLAUS_DEBUG") != nullptr;
  if (on) fmt::print(stderr, "{}\n", fmt::format(f, std::forward<T>(args)...));
}
}
