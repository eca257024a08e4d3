// The whole chain through the program, on a small scene.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <regex>
#include <set>
#include <thread>

#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/sequence.h"
#include "evaluation/results/results.h"
#include "harness/bench/process.h"
#include "harness/estimate_text.h"
#include "simulator/render/renderer.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

// Files of an estimate that differ between equal runs.
const std::vector<std::string> kMeasured = {"timing.csv", "usage.csv"};

class Pipeline : public testing::Test {
 protected:
  void SetUp() override { write_text(scene(), small_scene_yaml()); }
  const fs::path& folder() const { return temp_.path(); }
  fs::path scene() const { return folder() / "small.yaml"; }
  // The same with every sensor on.
  fs::path scene_with_lidar() const {
    write_text(folder() / "lidar.yaml", small_scene_yaml() + "imu: {}\nlidar: {pattern: livox_mid40}\n");
    return folder() / "lidar.yaml";
  }
  void ok(const std::vector<std::string>& arguments) const {
    const ProgramRun run = run_program(arguments);
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  fs::path bench_file(const std::string& scenes) const {
    const fs::path variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
    write_text(folder() / "bench.yaml",
               "scenes: [" + scenes + "]\nvariants: [" + variant.string() + "]\nseeds: [1]\noverlays: 2\n");
    return folder() / "bench.yaml";
  }

 private:
  TempFolder temp_;
};

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

TEST(Process, AHangingStageIsEndedAtItsLimit) {
  const TempFolder temp;
  const auto start = std::chrono::steady_clock::now();
  const ProcessResult result = run_process({"/bin/sleep", "60"}, temp.path() / "log", 0.2);
  EXPECT_FALSE(result.ok);
  EXPECT_EQ(result.message, "ran longer than 0.2 s");
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(30));
}

TEST(Process, SaysWhyAStageFailed) {
  const TempFolder temp;
  EXPECT_EQ(
      run_process({"/bin/sh", "-c", "echo first; echo last >&2; exit 3"}, temp.path() / "a", 10).message,
      "last");
  EXPECT_EQ(run_process({"/bin/sh", "-c", "kill -SEGV $$"}, temp.path() / "b", 10).message,
            "killed by signal 11 (Segmentation fault)");
  EXPECT_EQ(run_process({"/bin/false"}, temp.path() / "c", 10).message, "exit code 1");
  EXPECT_TRUE(run_process({"/bin/true"}, temp.path() / "d", 10).ok);
}

}  // namespace
}  // namespace uniquadric
