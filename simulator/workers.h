#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <new>
#include <type_traits>

namespace uniquadric {

/// Memory that processes forked while it lives share; throws std::bad_alloc.
std::shared_ptr<void> shared_memory(std::size_t size);

/// A value in such memory.
template <typename T>
std::shared_ptr<T> make_shared_value() {
  static_assert(std::is_trivially_destructible_v<T>);
  const std::shared_ptr<void> memory = shared_memory(sizeof(T));
  return {memory, new (memory.get()) T};
}

/// Numbers 0, 1, 2, ... below a limit, each handed out once, over all processes forked while it lives; and
/// how many of them are finished.
class SharedCounter {
 public:
  explicit SharedCounter(std::int64_t limit) : limit_(limit), state_(make_shared_value<State>()) {}
  /// The next number; the limit or more when none is left.
  std::int64_t take() { return state_->next++; }
  void finish() { ++state_->finished; }
  std::int64_t finished() const { return state_->finished; }
  std::int64_t limit() const { return limit_; }

 private:
  struct State {
    std::atomic<std::int64_t> next = 0, finished = 0;
  };
  static_assert(std::atomic<std::int64_t>::is_always_lock_free);
  std::int64_t limit_;
  std::shared_ptr<State> state_;
};

/// Runs `work(0)` .. `work(count - 1)`, each in a process of its own, forked from this one, and calls `idle`
/// now and then meanwhile. Processes instead of threads: llvmpipe's
/// contexts of one process share a lock around rasterisation, and crash when one asks for a resource that
/// another is drawing with (Mesa 22.3). When one fails, the others are ended and its InputError or
/// std::runtime_error is thrown here.
void run_workers(int count, const std::function<void(int)>& work, const std::function<void()>& idle);

}  // namespace uniquadric
