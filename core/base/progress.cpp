#include "core/base/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace uniquadric {
namespace {
using Clock = std::chrono::steady_clock;
constexpr auto kRedrawInterval = std::chrono::milliseconds(200);
constexpr int kBarWidth = 30;  // characters

double seconds_since(Clock::time_point t) {
  return std::chrono::duration<double>(Clock::now() - t).count();
}
}  // namespace

Progress::Progress(std::string label, std::int64_t total, bool quiet, std::chrono::milliseconds silent)
    : label_(std::move(label)),
      total_(total),
      quiet_(quiet),
      terminal_(isatty(STDERR_FILENO) == 1),
      silent_(silent),
      start_(Clock::now()) {}

Progress::~Progress() {
  if (!quiet_ && terminal_ && drawn_ != Clock::time_point{}) fmt::print(stderr, "\r\033[K");
}

void Progress::advance(std::int64_t steps) {
  const std::lock_guard lock(mutex_);
  done_ += steps;
  if (!quiet_ && Clock::now() - start_ >= silent_) draw();
}

void Progress::note(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  fmt::print(stderr, "{}{}\n", terminal_ ? "\r\033[K" : "", line);
}

void Progress::draw() {
  const double fraction = total_ > 0 ? static_cast<double>(done_) / static_cast<double>(total_) : 1;
  const double elapsed = seconds_since(start_);
  if (!terminal_) {
    const int tenth = static_cast<int>(fraction * 10);
    if (tenth == drawn_tenth_) return;
    drawn_tenth_ = tenth;
    fmt::print(stderr, "{}: {}/{} ({:.1f} s)\n", label_, done_, total_, elapsed);
    return;
  }
  if (done_ < total_ && Clock::now() - drawn_ < kRedrawInterval) return;
  drawn_ = Clock::now();
  const int filled = static_cast<int>(fraction * kBarWidth);
  fmt::print(stderr, "\r\033[K{} [{:#<{}}{:.<{}}] {}/{}  {:.0f} s left", label_, "", filled, "",
             kBarWidth - filled, done_, total_, fraction > 0 ? elapsed * (1 - fraction) / fraction : 0.0);
  std::fflush(stderr);
}

}  // namespace uniquadric
