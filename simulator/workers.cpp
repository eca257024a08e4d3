#include "simulator/workers.h"

#include <fmt/format.h>
#include <malloc.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <new>
#include <opencv2/core/utility.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/base/end_with_parent.h"
#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr int kIdleInterval_ms = 100;
constexpr char kInputError = 'i', kOutOfMemory = 'm', kOtherError = 'e';

struct Worker {
  pid_t process = -1;
  int said = -1;        // read end of the pipe on which it says why it failed; closed when it ends
  std::string message;  // kind, then text
  bool ended = false;
};

// Images are freed and made anew all the time; by default their memory goes back to the system and comes as
// new pages, which cost more than what is written to them.
void keep_freed_memory() {
#ifdef __GLIBC__
  constexpr int kMost = 1 << 30;
  mallopt(M_MMAP_THRESHOLD, 32 << 20);  // the most that glibc takes
  mallopt(M_TRIM_THRESHOLD, kMost);
#endif
}

// A child's life: it dies with its parent, and OpenCV's threads, which fork leaves behind, are not waited
// for.
[[noreturn]] void live(const std::function<void(int)>& work, int number, int say, pid_t parent) {
  end_with_parent(parent);
  cv::setNumThreads(1);
  keep_freed_memory();
  std::string failure;
  try {
    work(number);
  } catch (const InputError& e) {
    failure = kInputError + std::string(e.what());
  } catch (const std::bad_alloc&) {
    failure = kOutOfMemory;
  } catch (const std::exception& e) {
    failure = kOtherError + std::string(e.what());
  }
  const bool told = write(say, failure.data(), failure.size()) == static_cast<ssize_t>(failure.size());
  _exit(failure.empty() && told ? 0 : 1);
}

Worker start(const std::function<void(int)>& work, int number) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("a pipe to a worker cannot be made");
  const pid_t parent = getpid();
  Worker worker{fork(), ends[0], "", false};
  if (worker.process == 0) live(work, number, ends[1], parent);
  close(ends[1]);
  if (worker.process < 0) throw std::runtime_error("a worker process cannot be started");
  return worker;
}

// Reads what the worker says; at the end takes its exit status.
void listen(Worker& worker) {
  char buffer[1024];
  const ssize_t count = read(worker.said, buffer, sizeof buffer);
  if (count > 0) worker.message.append(buffer, static_cast<std::size_t>(count));
  if (count != 0) return;
  int status = 0;
  while (waitpid(worker.process, &status, 0) < 0 && errno == EINTR) {
  }
  worker.ended = true;
  if (WIFSIGNALED(status))
    worker.message = fmt::format("{}a worker was ended by signal {}", kOtherError, WTERMSIG(status));
  else if (WEXITSTATUS(status) != 0 && worker.message.empty())
    worker.message = fmt::format("{}a worker failed", kOtherError);
}

// The others of a failed worker are ended: what they finished is on disk, and a later call goes on from
// there.
void end_all(std::vector<Worker>& workers) {
  for (Worker& worker : workers) {
    if (!worker.ended) {
      kill(worker.process, SIGKILL);
      while (waitpid(worker.process, nullptr, 0) < 0 && errno == EINTR) {
      }
    }
    close(worker.said);
  }
}

[[noreturn]] void fail(const std::string& message) {
  if (message[0] == kInputError) throw InputError(message.substr(1));
  if (message[0] == kOutOfMemory) throw std::bad_alloc();
  throw std::runtime_error(message.substr(1));
}

// Waits until all have ended; the message of the first that failed, or nothing.
std::string wait_for(std::vector<Worker>& workers, const std::function<void()>& idle) {
  while (true) {
    std::vector<pollfd> events;
    for (const Worker& worker : workers) events.push_back({worker.ended ? -1 : worker.said, POLLIN, 0});
    poll(events.data(), events.size(), kIdleInterval_ms);
    bool all_ended = true;
    for (std::size_t i = 0; i < workers.size(); ++i) {
      if (events[i].revents != 0) listen(workers[i]);
      if (workers[i].ended && !workers[i].message.empty()) return workers[i].message;
      all_ended = all_ended && workers[i].ended;
    }
    idle();
    if (all_ended) return "";
  }
}

}  // namespace

std::shared_ptr<void> shared_memory(std::size_t size) {
  void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return {memory, [size](void* begin) { munmap(begin, size); }};
}

void run_workers(int count, const std::function<void(int)>& work, const std::function<void()>& idle) {
  std::vector<Worker> workers;
  for (int i = 0; i < count; ++i) workers.push_back(start(work, i));
  const std::string failure = wait_for(workers, idle);
  end_all(workers);
  if (!failure.empty()) fail(failure);
}

}  // namespace uniquadric
