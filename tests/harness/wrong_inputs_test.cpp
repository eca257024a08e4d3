// Wrong inputs that are well-formed, through `info --check --deep`: most are named, and the sound ones are
// not.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <iostream>
#include <sstream>

#include "tests/harness/program.h"
#include "tests/harness/wrong_inputs.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class WrongInputs : public testing::Test {
 protected:
  // A sequence of a family, small and short.
  fs::path simulated(const std::string& family, const std::string& seed,
                     const std::vector<std::string>& sets) {
    const fs::path scene = temp_.path() / (family + ".yaml"), out = temp_.path() / family;
    EXPECT_EQ(run_program({"generate", family, scene, "--seed", seed, "--set", "frames=40"}).exit_code, 0);
    std::vector<std::string> arguments{"simulate", scene, out, "--quiet"};
    for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return out / "sequence";
  }

  static ProgramRun check(const fs::path& folder) {
    return run_program({"info", folder, "--check", "--deep"});
  }

  // The lines that tell one, but for files that are left over: those only this test leaves.
  static std::string problems(const ProgramRun& run) {
    std::istringstream lines(run.out);
    std::string text, line;
    while (std::getline(lines, line))
      if (line.starts_with("problem: ") && !line.ends_with("stands in no list")) text += line + "\n";
    return text;
  }

  // Counts those that are named, and prints what is said of each.
  void look(const std::vector<WrongInput>& inputs, const fs::path& sound) {
    for (const WrongInput& input : inputs) {
      const fs::path folder = temp_.path() / "wrong";
      write_wrong(input, sound, folder);
      const std::string text = problems(check(folder));
      ++inputs_;
      named_ += !text.empty();
      std::cout << (text.empty() ? "MISSED " : "named  ") << input.name << "\n";
      if (!text.empty()) std::cout << "         " << text.substr(0, text.find('\n')) << "\n";
      fs::remove_all(folder);
    }
  }

  TempFolder temp_;
  int inputs_ = 0, named_ = 0;
};

const std::vector<std::string> kSmall = {"camera.calibration.width=320", "camera.calibration.height=240",
                                         "camera.calibration.fx=262.5",  "camera.calibration.fy=262.5",
                                         "camera.calibration.cx=159.5",  "camera.calibration.cy=119.5"};

TEST_F(WrongInputs, MostAreNamedAndSoundOnesAreNot) {
  std::vector<std::string> with_imu = kSmall, with_scans = kSmall;
  with_imu.emplace_back("imu.rate_hz=200");
  with_scans.insert(with_scans.end(), {"imu.rate_hz=200", "lidar.pattern=os1_64", "camera.depth=false"});
  const fs::path camera = simulated("tabletop", "3", with_imu), scans = simulated("room", "1", with_scans);
  EXPECT_EQ(problems(check(camera)), "");
  EXPECT_EQ(problems(check(scans)), "");
  look(wrong_camera_inputs(), camera);
  look(wrong_scan_inputs(), scans);
  std::cout << fmt::format("{} of {} named\n", named_, inputs_);
  EXPECT_GE(named_ * 47, inputs_ * 38);
}

}  // namespace
}  // namespace uniquadric
