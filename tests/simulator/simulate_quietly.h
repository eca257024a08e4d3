#pragma once

#include "simulator/simulate.h"

namespace uniquadric {

inline SimulateOptions quiet(int threads = 2, std::uint64_t seed = 0) {
  SimulateOptions options;
  options.seed = seed;
  options.threads = threads;
  options.quiet = true;
  return options;
}

}  // namespace uniquadric
