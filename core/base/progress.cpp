#include "core/base/progress.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
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

std::size_t columns_of_terminal() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
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

void Progress::skip(std::int64_t steps) {
  const std::lock_guard lock(mutex_);
  skipped_ += steps;
  done_ += steps;
  if (!quiet_ && Clock::now() - start_ >= silent_) draw();
}

void Progress::say(const std::string& what) {
  const std::lock_guard lock(mutex_);
  what_ = what;
  if (!quiet_ && terminal_ && Clock::now() - start_ >= silent_) draw();
}

void Progress::note(const std::string& line) {
  const std::lock_guard lock(mutex_);
  if (quiet_) return;
  fmt::print(stderr, "{}{}\n", terminal_ ? "\r\033[K" : "", line);
}

std::string Progress::time_left(double elapsed_s) const {
  const auto made = static_cast<double>(done_ - skipped_), rest = static_cast<double>(total_ - done_);
  if (made <= 0 || elapsed_s <= 0) return "";
  const double rate = made / elapsed_s, left_s = rest / rate;
  return fmt::format("  {}  {} left",
                     rate < 1 ? fmt::format("{:.1f}/min", 60 * rate) : fmt::format("{:.1f}/s", rate),
                     left_s < 100 ? fmt::format("{:.0f} s", left_s) : fmt::format("{:.0f} min", left_s / 60));
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
  const std::string line = fmt::format("{} [{:#<{}}{:.<{}}] {}/{}{}  {}", label_, "", filled, "",
                                       kBarWidth - filled, done_, total_, time_left(elapsed), what_);
  fmt::print(stderr, "\r\033[K{}", line.substr(0, columns_of_terminal() - 1));
  std::fflush(stderr);
}

}  // namespace uniquadric
