#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace uniquadric {

/// Numbers of `most` of n things at even steps, from 0 on; of all of them where there are no more.
inline std::vector<std::ptrdiff_t> even_choice(std::ptrdiff_t n, std::ptrdiff_t most) {
  const std::ptrdiff_t count = std::min(n, most);
  std::vector<std::ptrdiff_t> chosen;
  for (std::ptrdiff_t i = 0; i < count; ++i) chosen.push_back(i * n / count);
  return chosen;
}

}  // namespace uniquadric
