#pragma once

#include <chrono>
#include <cstdint>
#include <mutex>
#include <string>

namespace uniquadric {

/// Progress on stderr: a bar with rate and time left, once a step was done, on a terminal, a plain line each
/// tenth elsewhere, nothing when quiet or in the first `silent` time. Thread-safe.
class Progress {
 public:
  Progress(std::string label, std::int64_t total, bool quiet, std::chrono::milliseconds silent = {});
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  void advance(std::int64_t steps = 1);
  /// Steps that were done before: they tell nothing of the time that is left.
  void skip(std::int64_t steps);
  /// What is under way, shown behind the bar.
  void say(const std::string& what);
  /// A line of its own above the bar.
  void note(const std::string& line);

 private:
  void draw();
  std::string time_left(double elapsed_s) const;
  std::string label_;
  std::string what_{};
  std::int64_t total_, done_ = 0, skipped_ = 0;
  bool quiet_, terminal_;
  std::chrono::milliseconds silent_;
  int drawn_tenth_ = 0;
  std::chrono::steady_clock::time_point start_, drawn_;
  std::mutex mutex_;
};

}  // namespace uniquadric
