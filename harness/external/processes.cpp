#include "harness/external/processes.h"

#include <dirent.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <map>
#include <optional>
#include <string>

namespace uniquadric {
namespace {

// From /proc/PID/stat: "PID (NAME) STATE PARENT ...", where the name may hold anything.
std::optional<pid_t> parent_of(const std::string& pid) {
  std::ifstream in("/proc/" + pid + "/stat");
  std::string text;
  if (!std::getline(in, text, '\0')) return std::nullopt;
  const std::size_t end = text.rfind(')');
  if (end == std::string::npos || end + 4 >= text.size()) return std::nullopt;
  return static_cast<pid_t>(std::strtol(text.c_str() + end + 4, nullptr, 10));
}

std::multimap<pid_t, pid_t> children_by_parent() {
  std::multimap<pid_t, pid_t> children;
  DIR* const folder = opendir("/proc");
  if (!folder) return children;
  while (const dirent* entry = readdir(folder)) {
    const auto pid = static_cast<pid_t>(std::strtol(entry->d_name, nullptr, 10));
    if (pid <= 0) continue;
    if (const auto parent = parent_of(entry->d_name)) children.emplace(*parent, pid);
  }
  closedir(folder);
  return children;
}

}  // namespace

std::vector<pid_t> descendants(pid_t root) {
  const auto children = children_by_parent();
  std::vector<pid_t> found;
  const auto add_children_of = [&](pid_t parent) {
    const auto [begin, end] = children.equal_range(parent);
    for (auto it = begin; it != end; ++it) found.push_back(it->second);
  };
  add_children_of(root);
  for (std::size_t i = 0; i < found.size(); ++i) add_children_of(pid_t{found[i]});
  return found;
}

double resident_bytes(const std::vector<pid_t>& processes) {
  double own_pages = 0, shared_pages = 0;
  for (const pid_t pid : processes) {
    double size = 0, resident = 0, shared = 0;
    std::ifstream("/proc/" + std::to_string(pid) + "/statm") >> size >> resident >> shared;
    own_pages += std::max(0.0, resident - shared);
    shared_pages = std::max(shared_pages, shared);
  }
  return (own_pages + shared_pages) * static_cast<double>(sysconf(_SC_PAGESIZE));
}

}  // namespace uniquadric
