#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace uniquadric {

/// What a stage of the estimator took on one frame.
struct StageTime {
  std::int64_t frame = 0;
  const char* stage = "";
  double ms = 0;
};

/// `frame,stage,ms` with a line a stage, or such lines after those of `text`.
std::string timing_csv(const std::vector<StageTime>& times, std::string text = "frame,stage,ms\n");

/// Notes the time since it was last asked as that of a stage.
class Stopwatch {
 public:
  Stopwatch(std::int64_t frame, std::vector<StageTime>& times) : frame_(frame), times_(times) {}
  void stop(const char* stage) {
    const auto now = std::chrono::steady_clock::now();
    const double ms = std::chrono::duration<double, std::milli>(now - last_).count();
    last_ = now;
    times_.push_back({frame_, stage, ms});
  }

 private:
  std::int64_t frame_;
  std::vector<StageTime>& times_;
  std::chrono::steady_clock::time_point last_ = std::chrono::steady_clock::now();
};

}  // namespace uniquadric
