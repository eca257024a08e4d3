// The whole chain through the program, on a small scene.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/sequence.h"
#include "harness/bench/process.h"
#include "harness/estimate_text.h"
#include "simulator/render/renderer.h"
#include "tests/harness/pipeline_fixture.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Pipeline, TruthAgainstItselfIsPerfect) {
  ok({"simulate", scene(), folder() / "data", "--quiet"});
  const fs::path truth = folder() / "data/truth";
  const ProgramRun quiet = run_program({"evaluate", truth, truth, folder() / "evaluation", "--quiet"});
  ASSERT_EQ(quiet.exit_code, 0) << quiet.err;
  EXPECT_EQ(quiet.out, "");
  const ProgramRun shown = run_program({"evaluate", truth, truth, folder() / "shown"});
  EXPECT_TRUE(shown.out.starts_with("object  ")) << shown.out;
  EXPECT_EQ(std::count(shown.out.begin(), shown.out.end(), '\n'), 5)
      << shown.out;  // head, 2 objects, camera, units
  const json evaluation = json::parse(read_text(folder() / "evaluation/evaluation.json"));
  for (const char* metric : {"ape", "rpe"})
    for (const char* part : {"translation_m", "rotation_rad"}) {
      EXPECT_EQ(evaluation["camera"][metric][part]["max"], 0.0);
      for (const auto& object : evaluation["objects"]) EXPECT_EQ(object[metric][part]["max"], 0.0);
    }
  ASSERT_EQ(evaluation["objects"].size(), 2u);
  for (const auto& object : evaluation["objects"]) {
    EXPECT_EQ(object["iou3d"]["min"], 1.0);
    EXPECT_EQ(object["iou2d"]["min"], 1.0);
    EXPECT_EQ(object["coverage"], 1.0);
  }
  const ProgramRun map = run_program({"metric", "map", truth / "map.bt", truth / "map.bt", "--json"});
  ASSERT_EQ(map.exit_code, 0) << map.err;
  const json figures = json::parse(map.out);
  for (const char* figure : {"precision", "recall", "iou", "completeness"}) EXPECT_EQ(figures[figure], 1.0);
  EXPECT_GT(figures["true_occupied_voxels"], 100);
}

// Every line is that of the folder, and the last one tells how many warnings stand on stderr.
TEST_F(Pipeline, EstimateEndsWithASummary) {
  ok({"simulate", scene(), folder() / "data", "--quiet"});
  const fs::path sequence = folder() / "data/sequence", out = folder() / "out";
  const auto estimated = [&](const std::vector<std::string>& more) {
    std::vector<std::string> command = {"estimate", sequence, out, "--force", "--no-verify"};
    command.insert(command.end(), more.begin(), more.end());
    ProgramRun run = run_program(command);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run;
  };
  const auto expect_summary = [&](const ProgramRun& run, int warnings) {
    const std::string text = estimate_text(out), end = " s, " + std::to_string(warnings) + " warnings\n";
    ASSERT_TRUE(run.out.starts_with(text) && run.out.ends_with(end)) << run.out << run.err;
    const std::string seconds = run.out.substr(text.size(), run.out.size() - text.size() - end.size());
    EXPECT_TRUE(parse_double(seconds)) << seconds;
    int said = 0;
    for (std::size_t at = 0; (at = run.err.find("warning: ", at)) != run.err.npos; ++at) ++said;
    EXPECT_EQ(said, warnings) << run.err;
  };
  expect_summary(estimated({}), 0);
  EXPECT_EQ(estimated({"--quiet"}).out, "");
  fs::remove(sequence / "masks.txt");
  for (const auto& image : fs::directory_iterator(sequence / "depth"))
    write_png(image.path(), cv::Mat(read_image(image.path()).size(), CV_16UC1, cv::Scalar(0)));
  // masks.txt, that only what moves is found, depth images without depth, no camera, no object
  expect_summary(estimated({}), 5);
}

TEST_F(Pipeline, EstimateNeedsNoTruth) {
  ok({"simulate", scene(), folder() / "data", "--quiet"});
  ok({"estimate", folder() / "data/sequence", folder() / "a", "--quiet"});
  fs::rename(folder() / "data/truth", folder() / "hidden");
  ok({"estimate", folder() / "data/sequence", folder() / "b", "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "a", kMeasured), folder_hash(folder() / "b", kMeasured));
  fs::rename(folder() / "data/sequence", folder() / "alone");  // and no path of its origin
  ok({"estimate", folder() / "alone", folder() / "c", "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "a", kMeasured), folder_hash(folder() / "c", kMeasured));
}

TEST_F(Pipeline, SameBytesForAnyThreads) {
  const fs::path all_sensors = scene_with_lidar();
  ok({"simulate", all_sensors, folder() / "a", "--seed", "7", "--threads", "1", "--quiet"});
  ok({"simulate", all_sensors, folder() / "b", "--seed", "7", "--threads", "2", "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "a"), folder_hash(folder() / "b"));
  for (const char* threads : {"1", "2"})
    ok({"estimate", folder() / "a/sequence", folder() / (std::string("e") + threads), "--threads", threads,
        "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "e1", kMeasured), folder_hash(folder() / "e2", kMeasured));
}

// A single frame lies within the first scan's time: there is no scan, and nothing is wrong.
TEST_F(Pipeline, OneFrameOfEverySensorIsACompleteSequence) {
  const fs::path data = folder() / "data";
  ok({"simulate", scene_with_lidar(), data, "--frames", "1", "--quiet"});
  ok({"info", data, "--check"});
  ok({"estimate", data / "sequence", folder() / "estimate", "--quiet"});
  ok({"simulate", scene_with_lidar(), data, "--frames", "2", "--quiet", "--force"});
  ok({"info", data, "--check"});
}

TEST_F(Pipeline, InfoNamesEverySensor) {
  const fs::path all_sensors = scene_with_lidar();
  ok({"simulate", all_sensors, folder() / "data", "--quiet"});
  const ProgramRun of_scene = run_program({"info", all_sensors}),
                   of_data = run_program({"info", folder() / "data"});
  for (const std::string line : {"\nlidar: livox_mid40, 10 Hz\n", "\nimu: 200 Hz\n"})
    EXPECT_NE(of_scene.out.find(line), std::string::npos) << of_scene.out << of_scene.err;
  for (const std::string line : {"\nlidar: livox_mid40, 10 Hz; 3 scans over 0.200 s\n", "\nimu: 200 Hz\n",
                                 "\nframes: 4 over 0.300 s; 4 with depth, 4 with masks\n"})
    EXPECT_NE(of_data.out.find(line), std::string::npos) << of_data.out << of_data.err;
}

TEST_F(Pipeline, InfoSaysTheRealismAndWhatIsNotScored) {
  std::string text = small_scene_yaml();
  const fs::path plain = folder() / "plain.yaml", named = folder() / "named.yaml";
  write_text(plain, text);
  text.replace(text.find("    primitive: ball"), 0, "    scored: false\n");
  write_text(named, "realism: mild\n" + text);
  const auto info = [&](const fs::path& path) { return run_program({"info", path}).out; };
  for (const fs::path& scene : {plain, named}) {
    const fs::path data = folder() / scene.stem();
    ok({"simulate", scene, data, "--quiet", "--frames", "1"});
    ok({"info", data, "--check"});
    const bool is_named = scene == named;
    EXPECT_EQ(read_text(data / "sequence/sequence.yaml").find("\nrealism: \"mild\"\n") != text.npos,
              is_named);
    for (const fs::path& path : {scene, data}) {
      const std::string said = info(path);
      EXPECT_EQ(said.find(", realism mild\n") != said.npos, is_named) << said;
      EXPECT_EQ(said.find("realism") != said.npos, is_named) << said;
      const std::size_t ball = said.find(" 'ball'"), box = said.find(" 'box'");
      ASSERT_LT(std::max(ball, box), said.npos) << said;
      const auto line = [&](std::size_t at) { return said.substr(at, said.find('\n', at) - at); };
      EXPECT_EQ(line(ball).find(", not scored") != said.npos, is_named) << said;
      EXPECT_EQ(line(box).find(", not scored"), said.npos) << said;
    }
  }
}

// Every sensor's errors are others, and nothing of the truth is but what says of a measurement how wrong it
// is: the biases in imu.csv, and of each point that came back what it met.
TEST_F(Pipeline, AnotherSeedChangesTheNoiseAndNothingOfTheTruth) {
  const fs::path all_sensors = scene_with_lidar(), a = folder() / "a", b = folder() / "b";
  ok({"simulate", all_sensors, a, "--seed", "7", "--quiet"});
  ok({"simulate", all_sensors, b, "--seed", "8", "--quiet"});
  std::set<std::string> same, other;  // paths
  for (const auto& entry : fs::recursive_directory_iterator(a)) {
    const fs::path path = fs::relative(entry.path(), a);
    if (!entry.is_regular_file() || path.filename() == "hashes.txt") continue;
    (read_text(a / path) == read_text(b / path) ? same : other).insert(path.string());
  }
  for (const char* path :
       {"truth/camera.tum", "truth/camera.yaml", "truth/objects.yaml", "truth/objects/1.tum",
        "truth/objects/2.tum", "truth/map.bt", "truth/instances/000000.png", "truth/instances/visibility.csv",
        "sequence/rgb.txt", "sequence/lidar.txt", "sequence/camera_given.tum"})
    EXPECT_TRUE(same.contains(path)) << path;
  for (const char* path :
       {"sequence/rgb/000000.png", "sequence/depth/000003.png", "sequence/masks/000001.png",
        "sequence/lidar/000000.pcd", "sequence/imu.csv", "sequence/sequence.yaml"})
    EXPECT_TRUE(other.contains(path)) << path;
  for (const std::string& path : other)
    EXPECT_TRUE(path.starts_with("sequence/") || path.starts_with("truth/lidar/") ||
                path == "truth/imu_bias.csv")
        << path;
}

// What keeps EGL and OSMesa from being compared here; empty: nothing.
std::string not_comparable(const Scene& scene) {
  try {
    load_osmesa();
    const Renderer egl(scene, GlLibrary::egl);
    return egl.device().starts_with("llvmpipe") ? "" : "EGL draws with " + egl.device();
  } catch (const std::runtime_error& e) {
    return e.what();
  }
}

TEST_F(Pipeline, EglAndOsmesaSimulateTheSameBytesOnLlvmpipe) {
  if (const std::string why = not_comparable(load_scene(scene())); !why.empty()) GTEST_SKIP() << why;
  ok({"simulate", scene(), folder() / "osmesa", "--gl", "osmesa", "--quiet"});
  ok({"simulate", scene(), folder() / "egl", "--gl", "egl", "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "osmesa"), folder_hash(folder() / "egl"));
}

// A file that is no library stands before the true OSMesa.
TEST_F(Pipeline, WhereOsmesaCannotBeLoadedEglDrawsTheSameBytes) {
  if (const std::string why = not_comparable(load_scene(scene())); !why.empty()) GTEST_SKIP() << why;
  ok({"simulate", scene(), folder() / "osmesa", "--quiet"});
  write_text(folder() / "libOSMesa.so.8", "no library");
  const char* const path = std::getenv("LD_LIBRARY_PATH");
  const std::string before = path ? path : "";
  ASSERT_EQ(setenv("LD_LIBRARY_PATH", (folder().string() + ":" + before).c_str(), 1), 0);
  const ProgramRun refused =
      run_program({"simulate", scene(), folder() / "refused", "--gl", "osmesa", "--quiet"});
  const ProgramRun drawn = run_program({"simulate", scene(), folder() / "egl", "--quiet"});
  setenv("LD_LIBRARY_PATH", before.c_str(), 1);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_NE(refused.err.find("libOSMesa.so.8"), std::string::npos) << refused.err;
  ASSERT_EQ(drawn.exit_code, 0) << drawn.err;
  EXPECT_EQ(folder_hash(folder() / "osmesa"), folder_hash(folder() / "egl"));
}

// Without a vendor's library the dispatching one finds no display.
TEST_F(Pipeline, WithoutEglSaysSoAndWritesNothing) {
  ASSERT_EQ(setenv("__EGL_VENDOR_LIBRARY_FILENAMES", "/none", 1), 0);
  const ProgramRun run = run_program({"simulate", scene(), folder() / "out", "--gl", "egl", "--quiet"});
  unsetenv("__EGL_VENDOR_LIBRARY_FILENAMES");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_TRUE(run.err.starts_with("uniquadric: EGL cannot open a display")) << run.err;
  EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder()), {}), 1) << "only the scene";
}

// With every sensor on, gone on with by as many threads as were killed or by others.
TEST_F(Pipeline, AKilledSimulationResumesToTheSameBytes) {
  const std::string program = UNIQUADRIC_PROGRAM;
  const fs::path all_sensors = scene_with_lidar();
  ok({"simulate", all_sensors, folder() / "whole", "--frames", "40", "--quiet"});
  for (const std::vector<std::string>& threads : {std::vector<std::string>{"1"}, {"2"}, {"1", "2"}}) {
    const fs::path out = folder() / ("killed" + threads.front() + threads.back());
    const auto command = [&](std::size_t turn) -> std::vector<std::string> {
      return {program,    "simulate", all_sensors, out,
              "--frames", "40",       "--threads", threads[turn % threads.size()],
              "--quiet"};
    };
    std::size_t killed = 0;
    for (const double limit_s : {0.1, 0.4})  // it may have come to its end before it was killed
      if (!fs::exists(out)) killed += !run_process(command(killed), folder() / "log.txt", limit_s).ok;
    EXPECT_GT(killed, 0u);
    EXPECT_TRUE(fs::exists(out) || run_process(command(killed), folder() / "log.txt", 600).ok)
        << read_text(folder() / "log.txt");
    EXPECT_EQ(folder_hash(folder() / "whole"), folder_hash(out, {kPartialMarker})) << out;
    EXPECT_FALSE(fs::exists(out.string() + ".partial"));
  }
}

TEST_F(Pipeline, OneEstimateHasWhatWasKnownAtEachFrameLaterAndAtTheEnd) {
  const fs::path out = folder() / "out", file = bench_file("small.yaml");
  std::string config = read_text(file);
  const auto at = config.find("single_frame_obb.yaml");
  config.replace(at, 21, "superquadric.yaml");
  write_text(file, config);
  ok({"bench", file, out, "--quiet"});
  const fs::path cell = out / "cells/small/superquadric/seed_1";
  const std::string scores = read_text(out / "scores.csv");
  for (const std::string output : {"causal", "fixed_lag", "final"}) {
    const fs::path folder = output == "causal" ? cell / "estimate" : cell / "estimate" / output;
    EXPECT_NE(read_text(folder / "run.yaml").find("output: " + output), std::string::npos);
    EXPECT_TRUE(fs::exists(folder / "camera.tum")) << output;
    const std::string variant = output == "causal" ? "superquadric" : "superquadric@" + output;
    EXPECT_NE(scores.find("small,camera," + variant + ",1,ape_translation_rmse_m,"), std::string::npos)
        << variant;
  }
}

}  // namespace
}  // namespace uniquadric
