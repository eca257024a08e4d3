#include "harness/bench/process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "core/base/end_with_parent.h"
#include "core/base/files.h"

namespace uniquadric {
namespace {

constexpr int kExecFailed = 127;

// Between fork and exec only async-signal-safe calls are allowed.
[[noreturn]] void become(std::vector<char*>& arguments, int log, pid_t parent) {
  setpgid(0, 0);
  end_with_parent(parent);
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(arguments[0], arguments.data());
  _exit(kExecFailed);
}

// Whether the child ended within the limit.
bool wait_until(pid_t child, double limit_s) {
  const int handle = static_cast<int>(syscall(SYS_pidfd_open, child, 0));
  if (handle < 0) return true;  // an old kernel: waitpid below waits without limit
  pollfd event{handle, POLLIN, 0};
  int ready;
  do ready = poll(&event, 1, static_cast<int>(std::min(limit_s * 1e3, 2e9)));
  while (ready < 0 && errno == EINTR);
  close(handle);
  return ready != 0;
}

}  // namespace

ProcessResult run_process(const std::vector<std::string>& command, const std::filesystem::path& log,
                          double limit_s) {
  const int log_file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (log_file < 0) return {false, fmt::format("{}: {}", log.string(), std::strerror(errno))};
  std::vector<char*> arguments;
  for (const auto& argument : command) arguments.push_back(const_cast<char*>(argument.c_str()));
  arguments.push_back(nullptr);

  const pid_t parent = getpid(), child = fork();
  if (child == 0) become(arguments, log_file, parent);
  close(log_file);
  if (child < 0) return {false, fmt::format("cannot start: {}", std::strerror(errno))};
  setpgid(child, child);  // here too, so that there is a group to kill whichever of the two comes first

  const bool in_time = wait_until(child, limit_s);
  if (!in_time) kill(-child, SIGKILL);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!in_time) return {false, fmt::format("ran longer than {} s", limit_s)};
  if (WIFSIGNALED(status))
    return {false, fmt::format("killed by signal {} ({})", WTERMSIG(status), strsignal(WTERMSIG(status)))};
  if (WEXITSTATUS(status) == 0) return {true, ""};
  const std::string said = last_line(log);
  return {false, said.empty() ? fmt::format("exit code {}", WEXITSTATUS(status)) : said};
}

std::string last_line(const std::filesystem::path& log) {
  std::string text = read_text(log);
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text.substr(text.rfind('\n') + 1);
}

std::filesystem::path own_executable() {
  return std::filesystem::read_symlink("/proc/self/exe");
}

}  // namespace uniquadric
