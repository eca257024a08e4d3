#include "harness/external/sandbox.h"

#include <algorithm>

#include "core/base/apart.h"
#include "harness/external/process_tree.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What the system's programs and libraries are in; links among them stay links.
constexpr const char* kSystem[] = {"/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/etc"};
constexpr const char* kGpuPrefixes[] = {"nvidia", "dri", "kfd"};

using Arguments = std::vector<std::string>;

void add(Arguments& arguments, std::initializer_list<std::string> more) {
  arguments.insert(arguments.end(), more);
}

void add_system(Arguments& arguments) {
  for (const fs::path path : kSystem) {
    if (fs::is_symlink(path))
      add(arguments, {"--symlink", fs::read_symlink(path), path});
    else if (fs::exists(path))
      add(arguments, {"--ro-bind", path, path});
  }
}

// An installed simulator would make the truth of a sequence that names its scene and seed.
void hide_ourselves(Arguments& arguments) {
  for (const fs::path prefix : {"/usr", "/usr/local"}) {
    if (const fs::path program = prefix / "bin/uniquadric"; fs::exists(program))
      add(arguments, {"--ro-bind", "/dev/null", program});
    if (const fs::path data = prefix / "share/uniquadric"; fs::exists(data))
      add(arguments, {"--tmpfs", data});
  }
}

void add_devices(Arguments& arguments, const Sandbox& sandbox) {
  add(arguments, {"--proc", "/proc", "--dev", "/dev"});
  if (sandbox.gpu) {
    for (const auto& entry : fs::directory_iterator("/dev"))
      if (std::ranges::any_of(kGpuPrefixes, [&](const std::string& prefix) {
            return entry.path().filename().string().starts_with(prefix);
          }))
        add(arguments, {"--dev-bind", entry.path(), entry.path()});
    add(arguments, {"--ro-bind", "/sys", "/sys"});
  }
  add(arguments, {"--bind", sandbox.scratch / "shm", "/dev/shm", "--remount-ro", "/dev"});
}

}  // namespace

bool is_in_system(const fs::path& path) {
  const fs::path target = fs::canonical(path);
  return std::ranges::any_of(kSystem, [&](const char* folder) { return holds(folder, target); });
}

bool can_isolate() {
  static const bool can = [] {
    const TreeCommand command{{"bwrap", "--unshare-all", "--ro-bind", "/", "/", "true"},
                              {"PATH=/usr/local/bin:/usr/bin:/bin"},
                              "/"};
    TreeLimits limits;
    limits.time_s = 10;  // ours: it takes milliseconds
    return run_tree(command, limits, Printing::hidden).failure.empty();
  }();
  return can;
}

std::vector<std::string> isolated(const std::vector<std::string>& command, const Sandbox& sandbox) {
  Arguments arguments = {"bwrap", "--unshare-all", "--die-with-parent", "--new-session", "--cap-drop", "ALL"};
  add_system(arguments);
  hide_ourselves(arguments);
  add_devices(arguments, sandbox);
  add(arguments, {"--bind", sandbox.scratch / "tmp", "/tmp"});
  add(arguments, {"--tmpfs", kInsideSequence});
  for (const auto& [outside, inside] : sandbox.readable) add(arguments, {"--ro-bind", outside, inside});
  add(arguments, {"--remount-ro", kInsideSequence, "--bind", sandbox.out, kInsideOut});
  add(arguments, {"--dir", sandbox.folder, "--chdir", sandbox.folder, "--remount-ro", "/", "--"});
  arguments.insert(arguments.end(), command.begin(), command.end());
  return arguments;
}

}  // namespace uniquadric
