#include "tests/faults/faulty_bench.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <sstream>

#include "core/base/files.h"
#include "core/base/text.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// What differs between two runs that nothing disturbed: measured times, and logs of what went wrong before.
bool is_left_out(const fs::path& file) {
  static const std::set<std::string> names = {"timing.csv", "usage.csv", "command.txt", "log.txt",
                                              kPartialMarker};
  return names.contains(file.filename()) || file.extension() == ".log" || file.extension() == ".partial" ||
         file.string().ends_with(".timing.csv");
}

std::string lines_without(const std::string& text, const std::vector<std::string>& words) {
  std::string kept;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);)
    if (std::ranges::none_of(words, [&](const auto& word) { return line.find(word) != std::string::npos; }))
      kept += line + '\n';
  return kept;
}

// The bytes of a file without the measured times in it.
std::string lasting_bytes(const fs::path& file) {
  const std::string text = read_text(file);
  if (file.extension() == ".key")
    return text.substr(0, text.find('\n'));  // below: hashes of measured times too
  if (file.filename() == "scores.csv")
    return lines_without(text, {"frame_time_mean_ms", "wall_time_s", "cpu_time_s", "peak_memory_mb"});
  if (file.filename() == "report.md") return lines_without(text, {"- command: "});
  if (file.filename() ==
      "bench.yaml")  // paths are relative to the results, and faults have limits of their own
    return std::regex_replace(lines_without(text, {"stage_limit_s"}), std::regex("\"[^\"]*/"), "\"");
  if (file.filename() == "report.html") return text.ends_with("</html>\n") ? "whole" : text;
  if (file.filename() != "evaluation.json") return text;
  json evaluation = json::parse(text, nullptr, false);
  if (evaluation.is_discarded()) return text;
  evaluation.erase("timing_ms");
  evaluation.erase("usage");
  return evaluation.dump();
}

std::set<pid_t> children_of(pid_t process) {
  std::set<pid_t> children;
  std::error_code gone;
  for (const auto& task :
       fs::directory_iterator(fs::path("/proc") / std::to_string(process) / "task", gone)) {
    std::ifstream list(task.path() / "children");
    for (pid_t child; list >> child;) {
      children.insert(child);
      children.merge(children_of(child));
    }
  }
  return children;
}

}  // namespace

std::map<std::string, std::string> results_in(const fs::path& out) {
  std::map<std::string, std::string> results;
  if (!fs::exists(out)) return results;
  for (auto entry = fs::recursive_directory_iterator(out); entry != fs::recursive_directory_iterator();
       ++entry) {
    if (entry->path().extension() == ".partial")
      entry.disable_recursion_pending();
    else if (entry->is_regular_file() && !is_left_out(entry->path()))
      results[entry->path().lexically_relative(out)] = lasting_bytes(entry->path());
  }
  return results;
}

void expect_nothing_torn(const fs::path& out, const std::map<std::string, std::string>& whole) {
  for (const auto& [path, bytes] : results_in(out)) {
    const auto same = whole.find(path);
    if (same == whole.end())
      ADD_FAILURE() << path << " is in no undisturbed run";
    else
      EXPECT_TRUE(bytes == same->second) << path << " is torn or of other bytes";
  }
}

std::map<std::string, std::string> without_sequences(std::map<std::string, std::string> results) {
  std::erase_if(results, [](const auto& file) {
    return file.first.starts_with("simulations/") || file.first.starts_with("perceptions/");
  });
  return results;
}

fs::path write_faulty_bench(const fs::path& folder, const std::string& extra) {
  write_text(folder / "small.yaml", small_scene_yaml());
  const fs::path variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
  const fs::path file = folder / "bench.yaml";
  write_text(file, "scenes: [small.yaml]\nvariants: [" + variant.string() +
                       "]\nseeds: [1, 2]\noverlays: 1\nframes: 3\n" + extra);
  return file;
}

ProgramRun run_with_fault(const std::string& fault, const fs::path& bench, const fs::path& out) {
  setenv("UNIQUADRIC_FAULT", fault.c_str(), 1);
  setenv("ASAN_OPTIONS", "verify_asan_link_order=0", 1);
  setenv("LD_PRELOAD", UNIQUADRIC_FAULT_PRELOAD, 1);
  ProgramRun run = run_program({"bench", bench, out, "--quiet"});
  for (const char* name : {"LD_PRELOAD", "ASAN_OPTIONS", "UNIQUADRIC_FAULT"}) unsetenv(name);
  return run;
}

pid_t start_bench(const fs::path& bench, const fs::path& out) {
  const pid_t process = fork();
  if (process != 0) return process;
  if (!std::freopen("/dev/null", "w", stdout)) _exit(127);
  execl(UNIQUADRIC_PROGRAM, UNIQUADRIC_PROGRAM, "bench", bench.c_str(), out.c_str(), "--quiet", nullptr);
  _exit(127);
}

bool kill_bench(pid_t process, bool with_children) {
  if (with_children)
    for (const pid_t child : children_of(process)) kill(child, SIGKILL);
  kill(process, SIGKILL);
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace uniquadric
