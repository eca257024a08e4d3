#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>
#include <vector>

#include "core/base/files.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

// Files of an estimate that differ between equal runs.
inline const std::vector<std::string> kMeasured = {"timing.csv", "usage.csv"};

class Pipeline : public testing::Test {
 protected:
  void SetUp() override { write_text(scene(), small_scene_yaml()); }
  const std::filesystem::path& folder() const { return temp_.path(); }
  std::filesystem::path scene() const { return folder() / "small.yaml"; }
  // The same with every sensor on.
  std::filesystem::path scene_with_lidar() const {
    write_text(folder() / "lidar.yaml", small_scene_yaml() + "imu: {}\nlidar: {pattern: livox_mid40}\n");
    return folder() / "lidar.yaml";
  }
  void ok(const std::vector<std::string>& arguments) const {
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  std::filesystem::path bench_file(const std::string& scenes) const {
    const std::filesystem::path variant =
        std::filesystem::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
    write_text(folder() / "bench.yaml",
               "scenes: [" + scenes + "]\nvariants: [" + variant.string() + "]\nseeds: [1]\noverlays: 2\n");
    return folder() / "bench.yaml";
  }

 private:
  TempFolder temp_;
};

}  // namespace uniquadric
