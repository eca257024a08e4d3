#include "estimator/segmentation/segmenter_clock.h"

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>
#include <utility>

namespace uniquadric {
namespace {

class VirtualClock : public SegmenterClock {
 public:
  explicit VirtualClock(SlowSegmenter segmenter) : segmenter_(std::move(segmenter)) {}

  std::vector<SegmenterResult> step(const SegmenterInput& input, std::int64_t next_ns) override {
    std::vector<SegmenterResult> results;
    run_until(input.frame.stamp_ns - 1, results);
    waiting_ = input;  // a segmenter that is free at this very moment takes it
    run_until(input.frame.stamp_ns, results);
    newest_ = input.frame.frame;
    if (pending_ && pending_->frame == newest_ && arrival_ns_ < next_ns) run_until(arrival_ns_, results);
    return results;
  }

  std::int64_t oldest_pending() const override {
    if (pending_) return pending_->frame;
    return waiting_ ? waiting_->frame.frame : newest_;
  }

 private:
  // What happens until a time: results arrive, and the freed segmenter takes the frame that waits.
  void run_until(std::int64_t now_ns, std::vector<SegmenterResult>& results) {
    while (true) {
      if (pending_ && arrival_ns_ <= now_ns) {
        results.push_back(*std::exchange(pending_, std::nullopt));
        free_ns_ = arrival_ns_;
      }
      if (pending_ || !waiting_) return;
      start(*std::exchange(waiting_, std::nullopt));
    }
  }

  void start(const SegmenterInput& offered) {
    const auto latency_ns = segmenter_.latency_ns(offered.frame);
    if (!latency_ns) return;
    arrival_ns_ = std::max(free_ns_, offered.frame.stamp_ns) + *latency_ns;
    pending_ = {offered.frame.frame, segmenter_.segment(offered)};
  }

  SlowSegmenter segmenter_;
  std::optional<SegmenterInput> waiting_;  // the newest frame, until it is taken
  std::optional<SegmenterResult> pending_;
  std::int64_t arrival_ns_ = 0;  // of the pending result
  // since when the segmenter is free, while nothing is pending
  std::int64_t free_ns_ = std::numeric_limits<std::int64_t>::min();
  std::int64_t newest_ = 0;
};

class ThreadClock : public SegmenterClock {
 public:
  explicit ThreadClock(SlowSegmenter segmenter)
      : segmenter_(std::move(segmenter)), worker_([this](const std::stop_token& stop) { work(stop); }) {}

  std::vector<SegmenterResult> step(const SegmenterInput& input, std::int64_t /*next_ns*/) override {
    const std::lock_guard lock(mutex_);
    if (failure_) std::rethrow_exception(failure_);
    if (segmenter_.latency_ns(input.frame)) waiting_ = input;
    newest_ = input.frame.frame;
    wake_.notify_one();
    return std::exchange(done_, {});
  }

  std::int64_t oldest_pending() const override {
    const std::lock_guard lock(mutex_);
    if (!done_.empty()) return done_.front().frame;
    if (running_) return *running_;
    return waiting_ ? waiting_->frame.frame : newest_;
  }

 private:
  void work(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (wake_.wait(lock, stop, [&] { return waiting_.has_value(); })) {
      const SegmenterInput offered = *std::exchange(waiting_, std::nullopt);
      running_ = offered.frame.frame;
      lock.unlock();
      cv::Mat masks;
      std::exception_ptr failure;
      try {
        masks = run(offered);
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      failure_ = failure;
      running_.reset();
      if (failure) return;
      done_.push_back({offered.frame.frame, masks});
    }
  }

  cv::Mat run(const SegmenterInput& offered) const {
    const auto due = std::chrono::steady_clock::now() +
                     std::chrono::nanoseconds(segmenter_.latency_ns(offered.frame).value_or(0));
    cv::Mat masks = segmenter_.segment(offered);
    std::this_thread::sleep_until(due);
    return masks;
  }

  SlowSegmenter segmenter_;
  mutable std::mutex mutex_;
  std::condition_variable_any wake_;
  std::optional<SegmenterInput> waiting_;
  std::optional<std::int64_t> running_;  // the frame that the worker has
  std::vector<SegmenterResult> done_;
  std::int64_t newest_ = 0;
  std::exception_ptr failure_;
  std::jthread worker_;  // last: it ends before what it uses does
};

}  // namespace

std::unique_ptr<SegmenterClock> make_virtual_clock(SlowSegmenter segmenter) {
  return std::make_unique<VirtualClock>(std::move(segmenter));
}

std::unique_ptr<SegmenterClock> make_thread_clock(SlowSegmenter segmenter) {
  return std::make_unique<ThreadClock>(std::move(segmenter));
}

}  // namespace uniquadric
