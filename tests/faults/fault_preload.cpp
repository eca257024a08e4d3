// Preloaded into the program by the tests of faults: one stage of a bench goes wrong at a moment that is
// asked for. UNIQUADRIC_FAULT="STAGE KIND N": in `uniquadric STAGE`, just before its Nth file or folder gets
// its final name, KIND is crash, kill or hang; with memory the stage gets no more of it than N MB beside what
// it has at its start.
#include <dlfcn.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

namespace {

struct Fault {
  std::string kind;
  int count = 0;  // N
};

Fault fault_of_this_process() {
  std::string program, stage, wanted;
  std::ifstream arguments("/proc/self/cmdline");
  std::getline(arguments, program, '\0');
  std::getline(arguments, stage, '\0');
  const char* text = std::getenv("UNIQUADRIC_FAULT");
  Fault fault;
  std::istringstream(text ? text : "") >> wanted >> fault.kind >> fault.count;
  return wanted == stage ? fault : Fault{};
}

const Fault& fault() {
  static const Fault value = fault_of_this_process();
  return value;
}

void before_renaming() {
  static std::atomic<int> renames = 0;
  if (fault().kind.empty() || ++renames != fault().count) return;
  if (fault().kind == "crash") std::raise(SIGSEGV);
  if (fault().kind == "kill") std::raise(SIGKILL);
  while (fault().kind == "hang") pause();
}

[[gnu::constructor]] void limit_memory() {
  if (fault().kind != "memory") return;
  std::size_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const rlim_t limit =
      pages * static_cast<rlim_t>(sysconf(_SC_PAGESIZE)) + (static_cast<rlim_t>(fault().count) << 20);
  const rlimit both{limit, limit};
  setrlimit(RLIMIT_AS, &both);
}

}  // namespace

extern "C" int rename(const char* from, const char* to) noexcept {
  before_renaming();
  static const auto next = reinterpret_cast<int (*)(const char*, const char*)>(dlsym(RTLD_NEXT, "rename"));
  return next(from, to);
}

extern "C" int renameat2(int from_folder, const char* from, int to_folder, const char* to,
                         unsigned flags) noexcept {
  before_renaming();
  static const auto next =
      reinterpret_cast<int (*)(int, const char*, int, const char*, unsigned)>(dlsym(RTLD_NEXT, "renameat2"));
  return next(from_folder, from, to_folder, to, flags);
}
