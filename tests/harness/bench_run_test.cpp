// Benches through the program itself: what they write, resume and say.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <regex>
#include <thread>

#include "core/base/files.h"
#include "evaluation/results/results.h"
#include "tests/harness/pipeline_fixture.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

TEST_F(Pipeline, BenchEndsInAReportAndDoesNothingTwice) {
  const fs::path out = folder() / "out", file = bench_file("small.yaml");
  ok({"bench", file, out, "--quiet", "--keep"});
  for (const char* name : {"report.html", "report.md", "scores.csv", "cells.csv", "bench.yaml"})
    EXPECT_TRUE(fs::exists(out / name)) << name;
  const fs::path evaluation = out / "cells/small/single_frame_obb/seed_1/evaluation/evaluation.json";
  const auto made = fs::last_write_time(evaluation);
  const std::string scores = read_text(out / "scores.csv");
  EXPECT_NE(scores.find("small,box,single_frame_obb,1,iou3d_ellipsoid_mean,"), std::string::npos) << scores;
  const std::string before = folder_hash(out);
  ok({"bench", file, out, "--quiet", "--keep"});
  EXPECT_EQ(fs::last_write_time(evaluation), made);
  EXPECT_EQ(folder_hash(out), before);
  fs::remove_all(out / "cells/small/single_frame_obb/seed_1/evaluation");
  ok({"bench", file, out, "--quiet", "--keep"});
  EXPECT_EQ(read_text(out / "scores.csv"), scores);
}

// Cut short, of other bytes, or gone: the stage runs again, and nothing that is whole does.
TEST_F(Pipeline, BenchMendsWhatWasDamagedInItsResults) {
  const fs::path out = folder() / "out", file = bench_file("small.yaml");
  const fs::path cell = out / "cells/small/single_frame_obb/seed_1";
  ok({"bench", file, out, "--quiet"});
  const auto made = [&](const char* name) { return fs::last_write_time(cell / name); };
  const std::string estimate = folder_hash(cell / "estimate", kMeasured);
  const std::string frames = read_text(cell / "evaluation/frames.csv");
  const auto cut = [](const fs::path& path) { write_text(path, read_text(path).substr(0, 40)); };
  const auto garble = [](const fs::path& path) { write_text(path, "garbage"); };
  const auto remove = [](const fs::path& path) { fs::remove(path); };
  const auto damage = [&](const char* name, const auto& how) {
    how(cell / name);
    ok({"bench", file, out, "--quiet"});
    EXPECT_EQ(folder_hash(cell / "estimate", kMeasured), estimate) << name;
    EXPECT_EQ(read_text(cell / "evaluation/frames.csv"), frames) << name;
    EXPECT_TRUE(json::accept(read_text(cell / "evaluation/evaluation.json"))) << name;
  };
  const auto estimated = made("estimate/run.yaml");
  damage("evaluation/evaluation.json", cut);
  const auto evaluated = made("evaluation/frames.csv");
  damage("overlays/sheet.jpg", cut);
  EXPECT_EQ(made("evaluation/frames.csv"), evaluated);
  EXPECT_EQ(made("estimate/run.yaml"), estimated);
  damage("estimate/objects/1.tum", garble);
  damage("estimate/objects.csv", remove);
  EXPECT_NE(made("evaluation/frames.csv"), evaluated) << "times of another run";
}

TEST_F(Pipeline, BenchWithoutOverlays) {
  const fs::path out = folder() / "out", file = bench_file("small.yaml");
  const fs::path overlays = out / "cells/small/single_frame_obb/seed_1/overlays";
  ok({"bench", file, out, "--quiet"});
  EXPECT_TRUE(fs::exists(overlays / "sheet.jpg"));
  std::string config = read_text(file);
  config.replace(config.find("overlays: 2"), 11, "overlays: 0");
  write_text(file, config);
  ok({"bench", file, out, "--quiet"});
  EXPECT_FALSE(fs::exists(overlays)) << "they are of another estimate";
  EXPECT_NE(read_text(out / "cells.csv").find("small,single_frame_obb,1,ok,"), std::string::npos);
}

TEST_F(Pipeline, BenchSetsValuesOfAScene) {
  const fs::path out = folder() / "out";
  const auto item = [](const std::string& name, const std::string& frames) {
    return "{scene: small.yaml, name: " + name + ", set: {frames: " + frames + ", camera.depth: true}}";
  };
  ok({"bench", bench_file(item("two", "2") + ", " + item("three", "3")), out, "--quiet", "--keep"});
  EXPECT_NE(
      read_text(out / "bench.yaml")
          .find("{scene: \"../small.yaml\", name: \"two\", set: {\"frames\": 2, \"camera.depth\": true}}"),
      std::string::npos);
  ok({"simulate", scene(), folder() / "hand", "--set", "frames=2", "--set", "camera.depth=true", "--seed",
      "1", "--quiet"});
  const auto made = [&](const char* name) {
    return folder_hash(out / "simulations" / name / "seed_1/sequence");
  };
  EXPECT_EQ(made("two"), folder_hash(folder() / "hand/sequence")) << "the same as by hand";
  EXPECT_NE(made("two"), made("three"));
}

// The signal that ended a call of the program, sent as soon as `until` exists; its standard error in `err`.
int interrupted_by(int signal, const std::vector<std::string>& arguments, const fs::path& until,
                   const fs::path& err) {
  const pid_t child = fork();
  if (child == 0) {
    if (!std::freopen(err.c_str(), "w", stderr)) _exit(99);
    std::vector<char*> call = {const_cast<char*>(UNIQUADRIC_PROGRAM)};
    for (const std::string& argument : arguments) call.push_back(const_cast<char*>(argument.c_str()));
    call.push_back(nullptr);
    execv(UNIQUADRIC_PROGRAM, call.data());
    _exit(98);
  }
  for (int i = 0; i < 3000 && !fs::exists(until); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  kill(child, signal);
  int status = 0;
  waitpid(child, &status, 0);
  return WIFSIGNALED(status) ? WTERMSIG(status) : -1;
}

TEST_F(Pipeline, AnInterruptSaysWhatIsLeft) {
  const fs::path err = folder() / "err", results = folder() / "results";
  for (const int signal : {SIGINT, SIGTERM}) {
    const std::string out = folder() / ("data" + std::to_string(signal));
    const std::vector<std::string> simulate = {"simulate", scene(), out, "--quiet", "--set", "frames=3000"};
    EXPECT_EQ(interrupted_by(signal, simulate, out + ".partial/key", err), signal);
    EXPECT_EQ(read_text(err), "\nuniquadric: interrupted; what is done is kept in " + out +
                                  ".partial: the same command goes on with it\n");
    EXPECT_TRUE(fs::exists(out + ".partial"));
  }
  EXPECT_EQ(interrupted_by(SIGTERM, {"bench", bench_file("small.yaml"), results, "--quiet"},
                           results / "bench.yaml", err),
            SIGTERM);
  EXPECT_NE(read_text(err).find("what is done is kept in " + results.string()), std::string::npos);
  ok({"bench", folder() / "bench.yaml", results, "--quiet"});
}

// Scenes of files and of a family, with values set: the same scores, and the file says the same of itself.
TEST_F(Pipeline, BenchRunsItsOwnBenchFileAgain) {
  const fs::path out = folder() / "results/first", again = folder() / "results/again";
  const std::string drawn =
      "{family: room, name: room, count: 2, first_seed: 5, set: {frames: 4}, seeds: [3]}";
  const std::string small = "{scene: small.yaml, name: short, set: {frames: 4}, noise_scale: 0.5}";
  ok({"bench", bench_file(small + ", " + drawn), out, "--quiet"});
  ok({"bench", out / "bench.yaml", again, "--quiet"});
  EXPECT_EQ(read_text(out / "cells.csv"), read_text(again / "cells.csv"));
  const auto without_times = [](const std::string& csv) {
    return std::regex_replace(csv, std::regex(".*(time|memory).*\n"), "");
  };
  EXPECT_EQ(without_times(read_text(out / "scores.csv")), without_times(read_text(again / "scores.csv")));
  const std::string first = read_text(out / "bench.yaml");
  EXPECT_NE(first.find("scenes/room_5.yaml"), std::string::npos) << first;
  EXPECT_EQ(std::regex_replace(first, std::regex("\"scenes/"), "\"../first/scenes/"),
            read_text(again / "bench.yaml"));
}

TEST_F(Pipeline, BenchTakesAScenesNoiseAndSeeds) {
  const fs::path out = folder() / "out";
  const std::string half = "{scene: small.yaml, noise_scale: 0.5, seeds: [4, 5], name: small_half_noise}";
  ok({"bench", bench_file("small.yaml, " + half), out, "--quiet", "--keep"});
  const std::string cells = read_text(out / "cells.csv");
  for (const char* row : {"small,single_frame_obb,1,ok,", "small_half_noise,single_frame_obb,4,ok,",
                          "small_half_noise,single_frame_obb,5,ok,"})
    EXPECT_NE(cells.find(row), std::string::npos) << cells;
  EXPECT_EQ(std::count(cells.begin(), cells.end(), '\n'), 4);
  const std::string resolved = read_text(out / "bench.yaml");
  EXPECT_NE(resolved.find("name: \"small_half_noise\", noise_scale: 0.5, seeds: [4, 5]}"), std::string::npos)
      << resolved;
  EXPECT_NE(read_text(out / "report.md").find("| small_half_noise | box | single_frame_obb | 2/2 |"),
            std::string::npos);
  // The same as by hand.
  ok({"simulate", scene(), folder() / "hand", "--noise-scale", "0.5", "--seed", "4", "--quiet"});
  EXPECT_EQ(folder_hash(folder() / "hand/sequence"),
            folder_hash(out / "simulations/small_half_noise/seed_4/sequence"));
  // Another noise is another sequence, and only of its scene.
  const auto made = [&](const char* folder) {
    return fs::last_write_time(out / "simulations" / folder / "sequence/sequence.yaml");
  };
  const auto plain = made("small/seed_1"), halved = made("small_half_noise/seed_4");
  std::string doubled = half;
  doubled.replace(doubled.find("0.5"), 3, "2.0");
  ok({"bench", bench_file("small.yaml, " + doubled), out, "--quiet", "--keep"});
  EXPECT_EQ(made("small/seed_1"), plain);
  EXPECT_NE(made("small_half_noise/seed_4"), halved);
}

TEST_F(Pipeline, BenchReportsThePapersLidarRouteAgainstEmbree) {
  write_text(folder() / "octree.yaml",
             small_scene_yaml() + "lidar: {pattern: livox_mid40, method: depth_octree}\n");
  const fs::path out = folder() / "out";
  ok({"bench", bench_file("octree.yaml"), out, "--quiet"});
  EXPECT_FALSE(fs::exists(out / "simulations/octree/seed_1/truth"))
      << "the sequence is gone, the figures are not";
  for (const char* name : {"comparison.csv", "errors.csv", "timing.csv"})
    EXPECT_TRUE(fs::exists(out / "lidar/octree/seed_1" / name)) << name;
  const Results results = read_results(out);
  ASSERT_EQ(results.lidar.size(), 1u);
  const LidarRoutes& routes = results.lidar[0];
  EXPECT_EQ(routes.scans, 3);
  EXPECT_GT(routes.completeness(), 0.9);
  EXPECT_GT(routes.rms_m, 0.01);        // cells are 0.1 m
  EXPECT_LT(routes.median_abs_m, 0.2);  // oblique walls, a moving camera
  std::int64_t beams = 0;
  for (const ErrorCell& cell : routes.errors) beams += cell.beams;
  EXPECT_EQ(beams, routes.matched);
  EXPECT_TRUE(routes.speed_ratio());
  write_text(out / "lidar/octree/seed_1/comparison.csv", "scan,beams\n");
  ok({"bench", bench_file("octree.yaml"), out, "--quiet"});
  EXPECT_EQ(read_results(out).lidar.at(0).matched, routes.matched) << "mended";
  EXPECT_FALSE(fs::exists(out / "simulations/octree/seed_1"));
  EXPECT_NE(read_text(out / "report.md").find("| octree | 1 | 3 |"), std::string::npos);
}

TEST_F(Pipeline, BenchSurvivesAFailingCellAndCountsIt) {
  write_text(folder() / "none.txt", "0 0 0 3 3\n");  // a box about nothing: its cell fails
  write_text(folder() / "blind.yaml", small_scene_yaml());
  const fs::path out = folder() / "out";
  const std::string blind = "{scene: blind.yaml, prompt: \"boxes:none.txt\"}";
  const ProgramRun run = run_program({"bench", bench_file("small.yaml, " + blind), out, "--quiet"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("1 cell failed"), std::string::npos) << run.err;
  const std::string cells = read_text(out / "cells.csv");
  EXPECT_NE(cells.find("small,single_frame_obb,1,ok"), std::string::npos) << cells;
  EXPECT_NE(cells.find("blind,single_frame_obb,1,failed"), std::string::npos) << cells;
  EXPECT_NE(cells.find("none.txt"), std::string::npos) << cells;
  EXPECT_TRUE(fs::exists(out / "report.html"));
  EXPECT_FALSE(fs::exists(out / "simulations/small/seed_1"));  // removed after use; the failed one is kept
  EXPECT_TRUE(fs::exists(out / "simulations/blind/seed_1/sequence"));
}

}  // namespace
}  // namespace uniquadric
