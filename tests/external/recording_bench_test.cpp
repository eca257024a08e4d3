// Recordings in a bench: what `import` made of them stands in the place of a simulation.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/core/mat.hpp>

#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "evaluation/results/results.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class RecordingBench : public testing::Test {
 protected:
  void SetUp() override {
    write_text(folder() / "small.yaml", small_scene_yaml());
    const ProgramRun run = run_program({"simulate", folder() / "small.yaml", folder() / "with", "--quiet"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
    fs::copy(folder() / "with/sequence", folder() / "without", fs::copy_options::recursive);
  }
  const fs::path& folder() const { return temp_.path(); }
  fs::path out() const { return folder() / "out"; }
  ProgramRun bench(const std::string& scenes, const std::string& variant = "quadric_extents.yaml") const {
    const fs::path variants = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants";
    write_text(folder() / "bench.yaml", "scenes: [" + scenes + "]\nvariants: [" +
                                            (variants / variant).string() +
                                            "]\nseeds: [3, 4]\noverlays: 1\n");
    return run_program({"bench", folder() / "bench.yaml", out(), "--quiet"});
  }
  // A line of a prompt: the box about object 1 in the first frame, wider by some pixels.
  std::string box_of_first_mask(int wider_px) const {
    const cv::Mat masks = read_image(folder() / "with/sequence/masks/000000.png");
    int left = masks.cols, right = 0, top = masks.rows, bottom = 0;
    for (int v = 0; v < masks.rows; ++v)
      for (int u = 0; u < masks.cols; ++u)
        if (masks.at<std::uint16_t>(v, u) == 1) {
          left = std::min(left, u), right = std::max(right, u);
          top = std::min(top, v), bottom = std::max(bottom, v);
        }
    return fmt::format("0 {} {} {} {}\n", left, top, right - left + 1 + wider_px, bottom - top + 1);
  }
  std::string scores() const { return read_text(out() / "scores.csv"); }

 private:
  TempFolder temp_;
};

TEST_F(RecordingBench, WithTruthIsScoredLikeAScene) {
  const ProgramRun run = bench("{recording: with, name: mine}");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(scores().find("mine,box,quadric_extents,0,iou3d_ellipsoid_mean"), std::string::npos) << scores();
  EXPECT_EQ(scores().find("quadric_extents,3,"), std::string::npos);  // the bench's seeds are of scenes
  EXPECT_TRUE(fs::exists(folder() / "with/sequence/sequence.yaml"));
  EXPECT_FALSE(fs::exists(out() / "simulations"));
  EXPECT_NE(read_text(out() / "inputs.csv").find("recording,mine,"), std::string::npos);
  const auto made = fs::last_write_time(out() / "cells/mine/quadric_extents/seed_0/estimate/run.yaml");
  ASSERT_EQ(bench("{recording: with, name: mine}").exit_code, 0);
  EXPECT_EQ(fs::last_write_time(out() / "cells/mine/quadric_extents/seed_0/estimate/run.yaml"), made);
}

// Whatever of it changes, and though it needs no seeds.
TEST_F(RecordingBench, AnEditedRecordingRunsAgain) {
  const fs::path variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
  write_text(folder() / "b.yaml",
             "scenes: [{recording: with, name: mine}]\nvariants: [" + variant.string() + "]\n");
  const auto run = [&] { return run_program({"bench", folder() / "b.yaml", out(), "--quiet"}); };
  ASSERT_EQ(run().exit_code, 0);
  const fs::path result = out() / "cells/mine/single_frame_obb/seed_0/estimate/run.yaml";
  const auto made = fs::last_write_time(result);
  fs::copy_file(folder() / "with/sequence/depth/000001.png", folder() / "with/sequence/depth/000002.png",
                fs::copy_options::overwrite_existing);
  ASSERT_EQ(run().exit_code, 0);
  EXPECT_NE(fs::last_write_time(result), made);
}

// Sizes over time and overlays need no truth.
TEST_F(RecordingBench, WithoutTruthShowsSizesAndOverlays) {
  const ProgramRun run = bench("{recording: without, seeds: [5]}");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const fs::path cell = out() / "cells/without/quadric_extents/seed_5";
  EXPECT_TRUE(fs::exists(cell / "overlays/sheet.jpg"));
  EXPECT_NE(scores().find("without,all,quadric_extents,5,size_spread_mean"), std::string::npos) << scores();
  EXPECT_EQ(scores().find("iou3d"), std::string::npos);
  EXPECT_EQ(scores().find("mota"), std::string::npos);
  const CellEvaluation evaluation = read_cell_evaluation(cell / "evaluation");
  ASSERT_GE(evaluation.sizes.size(), 1u);
  EXPECT_NE(read_text(out() / "report.md").find("## Estimated objects where no true one is known"),
            std::string::npos);
}

TEST_F(RecordingBench, MayBeOptional) {
  const ProgramRun run = bench("{recording: nowhere, optional: true}, {recording: with, name: mine}");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.err.find("recording nowhere is not there and is left out"), std::string::npos) << run.err;
  expect_refused(bench("{recording: nowhere}"), "nowhere does not exist");
  EXPECT_NE(bench("{recording: nowhere, optional: true}").err.find("none of them is there"),
            std::string::npos);
  EXPECT_NE(bench("{recording: .}").err.find("holds no sequence"), std::string::npos);
}

// A prompt is part of what an estimate depends on.
TEST_F(RecordingBench, APromptIsPassedOn) {
  write_text(folder() / "boxes.txt", box_of_first_mask(0));
  const std::string scene = "{recording: with, name: mine, prompt: \"boxes:boxes.txt\"}";
  ASSERT_EQ(bench(scene).exit_code, 0);
  const fs::path run_file = out() / "cells/mine/quadric_extents/seed_0/estimate/run.yaml";
  EXPECT_NE(read_text(run_file).find("prompts: \"boxes.txt\""), std::string::npos);
  const auto made = fs::last_write_time(run_file);
  write_text(folder() / "boxes.txt", box_of_first_mask(1));
  ASSERT_EQ(bench(scene).exit_code, 0);
  EXPECT_NE(fs::last_write_time(run_file), made);
}

TEST_F(RecordingBench, AVariantWithoutItsSensorsIsNotApplicable) {
  const ProgramRun run = bench("{recording: with}", "lidar_only.yaml");
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const auto cells = read_cells(out() / "cells.csv");
  ASSERT_EQ(cells.size(), 1u);
  EXPECT_EQ(cells[0].status, CellStatus::not_applicable);
  EXPECT_EQ(cells[0].message, "the sequence has no lidar");
}

}  // namespace
}  // namespace uniquadric
