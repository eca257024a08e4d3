#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace uniquadric {

/// Progress on stderr: a bar with the time left on a terminal, a plain line each tenth elsewhere, nothing
/// when quiet or in the first `silent` time. Thread-safe.
class Progress {
 public:
  Progress(std::string label, std::int64_t total, bool quiet, std::chrono::milliseconds silent = {});
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t steps = 1);
  /// A line of its own above the bar.
  void note(const std::string& line);

 private:
  void draw();
  std::string label_;
  std::int64_t total_, done_ = 0;
  bool quiet_, terminal_;
  std::chrono::milliseconds silent_;
  int drawn_tenth_ = 0;
  std::chrono::steady_clock::time_point start_, drawn_;
  std::mutex mutex_;
};

}  // namespace uniquadric
