#pragma once

#include <algorithm>
#include <thread>

namespace uniquadric {

/// Threads (or processes) to work with: as many as asked for, but no more than there are cores, and all of
/// these for 0. More would gain nothing, and thousands would stop the machine.
inline int threads_to_use(int asked) {
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  return asked > 0 ? std::min(asked, cores) : cores;
}

}  // namespace uniquadric
