#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace uniquadric {

/// How long the stages of a simulation took. Measured, and so never a part of the folders it writes.
class StageTimes {
 public:
  /// Adds to the stage of that name; `count`: of the frames, scans, ... it made meanwhile.
  void add(const std::string& stage, double seconds, std::int64_t count = 1);
  /// `stage,count,ms_each`, a row a stage in order of their first appearance; stages of no count are left
  /// out.
  std::string csv() const;

 private:
  struct Stage {
    std::string name;
    double seconds = 0;
    std::int64_t count = 0;
  };
  std::vector<Stage> stages_;
};

/// Wall time since it was made.
class Stopwatch {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace uniquadric
