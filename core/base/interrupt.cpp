#include "core/base/interrupt.h"

#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstring>

namespace uniquadric {
namespace {

// A signal may come at any time: what it says is never freed, and is changed a few times a process.
std::atomic<const char*> left_behind = nullptr;

void say(const char* text) {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, std::strlen(text));
}

extern "C" void end_by(int signal) {
  const char* const left = left_behind;
  say("\nuniquadric: interrupted");
  if (left) say("; "), say(left);
  say("\n");
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

}  // namespace

void say_what_is_left_when_interrupted() {
  for (const int signal : {SIGINT, SIGTERM})
    if (std::signal(signal, end_by) == SIG_IGN) std::signal(signal, SIG_IGN);
}

void leave_when_interrupted(const std::string& what) {
  left_behind = what.empty() ? nullptr : strdup(what.c_str());
}

}  // namespace uniquadric
