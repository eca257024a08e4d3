#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "core/base/seconds.h"
#include "simulator/workers.h"

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
class StageClock {
 public:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// What becomes of a frame, in the order of the work: drawn, read back and its silhouettes counted; colour,
/// depth and masks with their sensors' errors and in the bytes of their files; these written.
enum class FrameStage { draw, color, depth, masks, write };
inline constexpr std::array kFrameStages = {"draw", "color", "depth", "masks", "write"};

/// Processor time that all workers together spend on each stage of their frames. A worker's first frame
/// stands apart, with all that is prepared for it: OpenGL compiles what it draws with when it first draws.
class FrameTimes {
 public:
  void add(FrameStage stage, double seconds) {
    sums_->stage_ns[static_cast<std::size_t>(stage)] += nanoseconds(seconds);
  }
  void count_frame() { ++sums_->frames; }
  void add_first_frame(double seconds) {
    sums_->first_ns += nanoseconds(seconds);
    ++sums_->workers;
  }
  void add_descriptions(double seconds) { sums_->descriptions_ns += nanoseconds(seconds); }
  /// Rows `first_frame` (of each worker), `frame_draw`, ... of the others, and `truth_and_imu`: what is
  /// written beside the frames.
  void add_to(StageTimes& times) const;

 private:
  struct Sums {
    std::array<std::atomic<std::int64_t>, kFrameStages.size()> stage_ns;
    std::atomic<std::int64_t> first_ns = 0, frames = 0, workers = 0, descriptions_ns = 0;
  };
  std::shared_ptr<Sums> sums_ = make_shared_value<Sums>();
};

/// Processor time of the calling thread [s]: what else runs on the machine counts little.
double thread_seconds();

/// Gives the thread's time since it was made, or since the last lap, to a stage.
class LapTimer {
 public:
  explicit LapTimer(FrameTimes& times) : times_(times), start_s_(thread_seconds()) {}
  void lap(FrameStage stage) {
    const double now_s = thread_seconds();
    times_.add(stage, now_s - start_s_);
    start_s_ = now_s;
  }

 private:
  FrameTimes& times_;
  double start_s_;
};

}  // namespace uniquadric
