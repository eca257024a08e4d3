#include "tests/harness/program.h"

#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>

#include "core/base/files.h"
#include "core/base/hash.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace fs = std::filesystem;

ProgramRun run_program(const std::vector<std::string>& arguments, const std::string& input) {
  const TempFolder temp;
  write_text(temp.path() / "in", input);
  std::string command = UNIQUADRIC_PROGRAM;
  for (const auto& argument : arguments) command += " '" + argument + "'";
  const std::string base = temp.path().string();
  const int status =
      std::system((command + " <" + base + "/in >" + base + "/out 2>" + base + "/err").c_str());
  const int code = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
  return {code, read_text(temp.path() / "out"), read_text(temp.path() / "err")};
}

void expect_refused(const ProgramRun& run, const std::string& what) {
  EXPECT_EQ(run.exit_code, 2) << run.err;
  EXPECT_EQ(run.out, "");
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_NE(run.err.find(what), std::string::npos) << "wanted: " << what << "\ngot: " << run.err;
}

std::string folder_hash(const fs::path& folder, const std::vector<std::string>& ignored) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file() &&
        std::find(ignored.begin(), ignored.end(), entry.path().filename()) == ignored.end())
      files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  EXPECT_FALSE(files.empty());
  Hash hash;
  for (const auto& file : files) hash.add(fs::relative(file, folder).string()).add_file(file);
  return hash.hex();
}

std::string small_scene_yaml() {
  return R"(name: small
frames: 4
rate_hz: 10
camera:
  calibration: {width: 160, height: 120, fx: 130, fy: 130, cx: 79.5, cy: 59.5}
  motion:
    kind: spline
    look_at_m: [0.3, 0, 0.5]
    may_overshoot: true
    waypoints: [{time_s: 0, position_m: [-1.2, -1.2, 1.2]},
                {time_s: 1, position_m: [0.0, -1.6, 1.3]},
                {time_s: 10, position_m: [1.2, -1.2, 1.2]}]
world:
  - {name: room, primitive: room, size_m: [5, 5, 3]}
objects:
  - id: 1
    name: box
    primitive: box
    size_m: [0.4, 0.3, 0.2]
    motion:
      kind: spline
      may_overshoot: true
      waypoints: [{time_s: 0, position_m: [0, 0, 0.5]},
                  {time_s: 1, position_m: [0.5, 0, 0]},
                  {time_s: 10, position_m: [0.6, 0.1, 0.3]}]
  - id: 2
    name: ball
    primitive: ball
    size_m: [0.3, 0.3, 0.3]
    motion: {kind: static, position_m: [0.6, 0.2, 0.3]}
)";
}

}  // namespace uniquadric
