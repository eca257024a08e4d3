#include "harness/external/process_tree.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/signalfd.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstring>
#include <optional>
#include <sstream>
#include <utility>

#include "core/base/end_with_parent.h"
#include "core/base/utf8.h"
#include "harness/external/processes.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;

constexpr double kBytesPerMb = 1e6;
constexpr int kPeriod_ms = 20;
constexpr std::size_t kMostPrinted = std::size_t{16} << 20, kLongestLine = 500;
constexpr int kCannotStart = 127;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

std::vector<char*> pointers(const std::vector<std::string>& texts) {
  std::vector<char*> result;
  for (const std::string& text : texts) result.push_back(const_cast<char*>(text.c_str()));
  result.push_back(nullptr);
  return result;
}

// Of regular files below a folder that processes write at the same time.
double bytes_below(const fs::path& folder) {
  double sum = 0;
  std::error_code gone;
  for (fs::recursive_directory_iterator it(folder, fs::directory_options::skip_permission_denied, gone), end;
       !gone && it != end; it.increment(gone)) {
    std::error_code no_file;
    if (!it->is_symlink(no_file) && it->is_regular_file(no_file))
      if (const auto size = it->file_size(no_file); !no_file) sum += static_cast<double>(size);
  }
  return sum;
}

// What the tree prints, passed on up to a length; the last line of it is kept to say why it failed.
class Printed {
 public:
  Printed(int descriptor, Printing printing) : descriptor_(descriptor), printing_(printing) {
    fcntl(descriptor_, F_SETFL, O_NONBLOCK);
  }

  void pass_on() {
    char buffer[1 << 16];
    for (int i = 0; i < 64; ++i) {  // whoever prints without an end is looked at for its limits in between
      const ssize_t n = read(descriptor_, buffer, sizeof(buffer));
      if (n <= 0) return;
      if (printing_ == Printing::passed_on) write_out({buffer, static_cast<std::size_t>(n)});
      remember({buffer, static_cast<std::size_t>(n)});
    }
  }

  std::string last_line() const {
    std::string text = tail_;
    while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.pop_back();
    text = text.substr(text.rfind('\n') + 1);
    for (char& c : text)
      if (static_cast<unsigned char>(c) < ' ' || c == '\x7f') c = ' ';  // it goes into messages and tables
    return text.size() > kLongestLine || !is_utf8(text) ? "" : text;
  }

 private:
  void write_out(std::string_view text) {
    static constexpr std::string_view kCut = "\n(the rest of what it printed is left out)\n";
    const std::size_t room = kMostPrinted - written_;
    const std::string_view part = text.substr(0, room);
    written_ += part.size();
    put(part);
    if (part.size() < text.size() && std::exchange(is_cut_, true) == false) put(kCut);
  }
  static void put(std::string_view text) {
    while (!text.empty()) {
      const ssize_t n = write(STDERR_FILENO, text.data(), text.size());
      if (n <= 0) return;
      text.remove_prefix(static_cast<std::size_t>(n));
    }
  }
  void remember(std::string_view text) {
    tail_.append(text);
    if (tail_.size() > 2 * kLongestLine) tail_.erase(0, tail_.size() - 2 * kLongestLine);
  }

  int descriptor_;
  Printing printing_;
  std::size_t written_ = 0;
  bool is_cut_ = false;
  std::string tail_;
};

rlim_t file_limit(const TreeLimits& limits) {
  constexpr double kMost = 9e18;  // of rlim_t and of files
  return static_cast<rlim_t>(std::min(limits.output_mb * kBytesPerMb, kMost));
}

// The program itself, a child of the supervisor.
[[noreturn]] void become(const TreeCommand& command, const TreeLimits& limits, int printed, pid_t parent) {
  std::vector<char*> arguments = pointers(command.arguments), environment = pointers(command.environment);
  end_with_parent(parent);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  for (const int signal : {SIGXFSZ, SIGPIPE, SIGTERM}) std::signal(signal, SIG_DFL);
  const rlimit files{file_limit(limits), file_limit(limits)}, no_core{0, 0};
  setrlimit(RLIMIT_FSIZE, &files);
  setrlimit(RLIMIT_CORE, &no_core);
  const int nothing = open("/dev/null", O_RDONLY);
  dup2(nothing, STDIN_FILENO);
  dup2(printed, STDOUT_FILENO);
  dup2(printed, STDERR_FILENO);
  syscall(SYS_close_range, 3U, ~0U, 0U);  // nothing of this process is open in it
  if (chdir(command.folder.c_str()) == 0) {
    environ = environment.data();  // where execvp looks for PATH
    execvp(arguments[0], arguments.data());
  }
  const std::string why = fmt::format("{}: {}\n", command.arguments.front(), std::strerror(errno));
  if (write(STDERR_FILENO, why.data(), why.size()) < 0) _exit(kCannotStart);
  _exit(kCannotStart);
}

// Why a status is a failure; empty: it is none. A shell and a sandbox say 128 + N of a child ended by signal
// N.
std::string failure_of(int status, const TreeLimits& limits, const std::string& last_line) {
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  if (code == 0) return "";
  const int signal = code - 128;
  if (signal == SIGXFSZ) return fmt::format("wrote more than {} MB", limits.output_mb);
  if (signal > 0 && signal < NSIG)
    return fmt::format("was ended by signal {} ({})", signal, strsignal(signal));
  return fmt::format("exit code {}{}{}", code, last_line.empty() ? "" : ": ", last_line);
}

// The process between: all orphans of the tree become its children, so that none outlives it.
class Supervisor {
 public:
  Supervisor(const TreeCommand& command, const TreeLimits& limits, Printing printing, pid_t parent)
      : limits_(limits) {
    setpgid(0, 0);  // Ctrl-C at a terminal ends its parent, and that ends the tree
    prctl(PR_SET_CHILD_SUBREAPER, 1);
    sigset_t handled;
    sigemptyset(&handled);
    sigaddset(&handled, SIGTERM);
    sigaddset(&handled, SIGCHLD);
    sigprocmask(SIG_BLOCK, &handled, nullptr);
    signals_ = signalfd(-1, &handled, SFD_CLOEXEC | SFD_NONBLOCK);
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) _exit(1);
    int ends[2];
    if (signals_ < 0 || pipe2(ends, O_CLOEXEC) != 0) {
      failure_ = fmt::format("cannot be watched: {}", std::strerror(errno));
      return;
    }
    const pid_t own = getpid();
    child_ = fork();
    if (child_ == 0) become(command, limits, ends[1], own);
    close(ends[1]);
    if (child_ < 0) failure_ = fmt::format("cannot be started: {}", std::strerror(errno));
    printed_descriptor_ = ends[0];
    printed_.emplace(ends[0], printing);
  }

  TreeResult run() {
    while (!failure_ && !status_) watch();
    end_all();
    if (printed_) printed_->pass_on();
    if (!failure_) failure_ = failure_of(*status_, limits_, printed_->last_line());
    rusage used{};
    getrusage(RUSAGE_CHILDREN, &used);
    const auto time_s = [](const timeval& t) { return double(t.tv_sec) + 1e-6 * double(t.tv_usec); };
    const double largest_mb = static_cast<double>(used.ru_maxrss) * 1024 / kBytesPerMb;
    return {*failure_,
            {seconds_since(start_), time_s(used.ru_utime) + time_s(used.ru_stime),
             std::max(peak_mb_, largest_mb)}};
  }

 private:
  void watch() {
    pollfd events[2] = {{printed_descriptor_, POLLIN, 0}, {signals_, POLLIN, 0}};
    poll(events, 2, kPeriod_ms);
    if (events[0].revents & POLLIN) printed_->pass_on();
    if (events[0].revents & POLLHUP) printed_descriptor_ = -1;  // poll passes over it
    take_signals();
    reap();
    if (seconds_since(looked_) * 1e3 < kPeriod_ms) return;
    looked_ = Clock::now();
    check_limits();
  }

  void take_signals() {
    signalfd_siginfo info{};
    while (read(signals_, &info, sizeof(info)) == sizeof(info))
      if (info.ssi_signo == SIGTERM) failure_ = "was ended from outside";
  }

  void reap() {
    int status = 0;
    for (pid_t ended; (ended = waitpid(-1, &status, WNOHANG)) > 0;)
      if (ended == child_) status_ = status;
  }

  void check_limits() {
    const double memory_mb = resident_bytes(descendants(getpid())) / kBytesPerMb;
    peak_mb_ = std::max(peak_mb_, memory_mb);
    if (memory_mb > limits_.memory_mb)
      failure_ = fmt::format("used more than {} MB of memory", limits_.memory_mb);
    if (seconds_since(start_) > limits_.time_s)
      failure_ = fmt::format("ran longer than {} s", limits_.time_s);
    if (++looks_ % 10 == 0 && bytes_below(limits_.output) > limits_.output_mb * kBytesPerMb)
      failure_ = fmt::format("wrote more than {} MB", limits_.output_mb);
  }

  // Again and again: between a look and a kill a process may start another.
  static void end_all() {
    int status = 0;
    while (true) {
      for (const pid_t process : descendants(getpid())) kill(process, SIGKILL);
      const pid_t ended = waitpid(-1, &status, WNOHANG);
      if (ended < 0 && errno == ECHILD) return;
      if (ended == 0) usleep(1000);
    }
  }

  TreeLimits limits_;
  int signals_ = -1, printed_descriptor_ = -1, looks_ = 0;
  pid_t child_ = -1;
  Clock::time_point start_ = Clock::now(), looked_ = start_;
  double peak_mb_ = 0;
  std::optional<Printed> printed_;
  std::optional<int> status_;
  std::optional<std::string> failure_;
};

std::string read_all(int descriptor) {
  std::string text;
  char buffer[4096];
  for (ssize_t n; (n = read(descriptor, buffer, sizeof(buffer))) != 0;) {
    if (n < 0 && errno != EINTR) break;
    if (n > 0) text.append(buffer, static_cast<std::size_t>(n));
  }
  return text;
}

std::string to_text(const TreeResult& result) {
  const ResourceUsage& u = result.usage;
  return fmt::format("{} {} {} {}", u.wall_time_s, u.cpu_time_s, u.peak_memory_mb, result.failure);
}

TreeResult from_text(const std::string& text) {
  TreeResult result;
  std::istringstream in(text);
  if (!(in >> result.usage.wall_time_s >> result.usage.cpu_time_s >> result.usage.peak_memory_mb))
    return {"its supervisor was ended", {}};
  in.ignore(1);
  std::getline(in, result.failure, '\0');
  return result;
}

}  // namespace

TreeResult run_tree(const TreeCommand& command, const TreeLimits& limits, Printing printing) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return {fmt::format("cannot be watched: {}", std::strerror(errno)), {}};
  const pid_t parent = getpid(), supervisor = fork();
  if (supervisor == 0) {
    close(ends[0]);
    const std::string text = to_text(Supervisor(command, limits, printing, parent).run());
    _exit(write(ends[1], text.data(), text.size()) == static_cast<ssize_t>(text.size()) ? 0 : 1);
  }
  close(ends[1]);
  const std::string text = supervisor > 0 ? read_all(ends[0]) : "";
  close(ends[0]);
  if (supervisor < 0) return {fmt::format("cannot be started: {}", std::strerror(errno)), {}};
  while (waitpid(supervisor, nullptr, 0) < 0 && errno == EINTR) {
  }
  return from_text(text);
}

}  // namespace uniquadric
