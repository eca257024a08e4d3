// The program's commands themselves: help, what they do not know, and `metric`.
#include "tests/harness/cli_fixture.h"

#include "core/sequence/pcd.h"
#include "core/sequence/ply.h"

namespace uniquadric {
namespace {

TEST_F(Cli, HelpFitsAScreenAndExitsZero) {
  for (const std::string command : {"simulate",
                                    "preview",
                                    "estimate",
                                    "evaluate",
                                    "bench",
                                    "report",
                                    "overlay",
                                    "scenery",
                                    "info",
                                    "metric",
                                    "metric map",
                                    "metric depth",
                                    "metric surface",
                                    "trajectory",
                                    "compare",
                                    "history",
                                    "import",
                                    "import tum",
                                    "import kitti-tracking",
                                    "import omd",
                                    "import euroc",
                                    "import bop",
                                    "import rosbag",
                                    "export",
                                    "perceive",
                                    "check-result",
                                    "convert-result",
                                    "completion"}) {
    std::vector<std::string> arguments{command, "--help"};
    if (const std::size_t blank = command.find(' '); blank != command.npos)
      arguments = {command.substr(0, blank), command.substr(blank + 1), "--help"};
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0);
    EXPECT_LE(std::count(run.out.begin(), run.out.end(), '\n'), 40) << command;
    EXPECT_NE(run.out.find("Usage"), std::string::npos);
  }
}

// Keys of variants that a bench sets are those that there are.
TEST_F(Cli, InfoReadsEveryBenchWithItsVariants) {
  for (const auto& file : fs::directory_iterator(fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/bench")) {
    if (file.path().extension() != ".yaml") continue;
    const ProgramRun run = run_program({"info", file.path()});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(run.out.starts_with("bench '" + file.path().stem().string() + "'")) << run.out;
  }
  const fs::path variants = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants";
  const fs::path bench = folder() / "bench.yaml";
  write_text(bench, "scenes: [" + (fs::path(UNIQUADRIC_SOURCE_DIR) / "scenes/static_2.yaml").string() +
                        "]\nseeds: [1]\nvariants:\n  - {variant: " + (variants / "bbox.yaml").string() +
                        ", name: x, set: {carving.cells: 4}}\n");
  expect_refusal({"info", bench}, "carving.cells");
}

// As many options as keys; the documentation has an example.
TEST_F(Cli, SetTakesOneKeyAnOptionAndTheHelpSaysSo) {
  for (const char* command : {"simulate", "preview", "generate", "estimate", "perceive"}) {
    const ProgramRun run = run_program({command, "--help"});
    EXPECT_NE(run.out.find("--set KEY=VALUE  "), std::string::npos) << run.out;
    EXPECT_NE(run.out.find("once for each key"), std::string::npos) << command;
  }
  const fs::path scene = folder() / "scene.yaml";
  expect_refusal({"generate", "room", scene, "--set", "difficulty=0.2", "frames=60"}, "frames=60");
  EXPECT_EQ(
      run_program({"generate", "room", scene, "--set", "difficulty=0.2", "--set", "frames=60"}).exit_code, 0);
  const std::string text = read_text(scene);
  EXPECT_NE(text.find("difficulty 0.2"), std::string::npos);
  EXPECT_NE(text.find("frames: 60\n"), std::string::npos);
}

TEST_F(Cli, TheFirstPagesShowHowToDrawAScene) {
  const fs::path source = UNIQUADRIC_SOURCE_DIR;
  const std::string readme = read_text(source / "README.md");
  EXPECT_NE(readme.find("$U generate tabletop "), std::string::npos);
  EXPECT_LT(std::count(readme.begin(), readme.end(), '\n'), 100);
  EXPECT_NE(read_text(source / "docs/first_scene.md").find("uniquadric generate tabletop "),
            std::string::npos);
}

TEST_F(Cli, RefusesWhatItDoesNotKnow) {
  expect_refusal({"simulat"}, "there is no subcommand 'simulat'");
  expect_refusal({}, "subcommand");
  expect_refusal({"simulate", "a.yaml", out(), "--sed", "1"}, "--sed");
  expect_refusal({"simulate", "a.yaml", out(), "--frames", "0"}, "--frames");
  expect_refusal({"simulate", "a.yaml", out(), "--gl", "glx"}, "--gl: glx not in {auto,osmesa,egl}");
  expect_refusal({"simulate", "a.yaml", out(), "--seed", "-5"}, "'-5' is no whole number");
  expect_refusal({"simulate", "a.yaml", out(), "--seed", "99999999999999999999"}, "is no whole number");
  for (const char* scale : {"-1", "nan", "inf", "x"})
    expect_refusal({"simulate", "a.yaml", out(), "--noise-scale", scale}, "is no number of at least 0");
  expect_refusal({"simulate", folder() / "none.yaml", out()}, "none.yaml: cannot be read");
  expect_refusal({"simulate", write("set.yaml", "frames: 3\n"), out(), "--set", "frames=0"},
                 "frames: expected 1 to 10000000, found 0 (set, not the file's)");
  expect_refusal({"metric", "iou4d"}, "iou4d");
  for (const char* option : {"--samples", "--seed"})
    expect_refusal({"metric", "iou3d", option, "10"}, option + std::string(" requires --method monte-carlo"));
}

TEST_F(Cli, MetricAnswersLineByLine) {
  const std::string sphere = R"({"c":[0,0,0],"q":[0,0,0,1],"a":[1,1,1]})";
  const ProgramRun run =
      run_program({"metric", "iou3d"}, R"({"id":1,"gt":)" + sphere + R"(,"est":)" + sphere + "}\nnonsense\n");
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find(R"("iou":1.0)"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find(R"("error")"), std::string::npos);
  EXPECT_EQ(std::count(run.out.begin(), run.out.end(), '\n'), 2);
}

TEST_F(Cli, MetricsOfFilesArePrintedAndAsJson) {
  write("plate.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n");
  PcdFile points{{{"x"}, {"y"}, {"z"}}, 2, {}, {}};
  for (const float v : {0.5f, 0.f, 3.25f, 0.f, 0.f, 2.75f}) points.put(v);
  write_pcd(folder() / "points.pcd", points);
  const std::vector<std::string> call = {"metric", "surface", folder() / "points.pcd",
                                         folder() / "plate.obj"};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), call.begin(), call.end());
    return more;
  };
  const ProgramRun run = run_program(
      with({"--pose", "0", "-0.5", "3", "0", "0", "0.70710678118654757", "-0.70710678118654757", "--json"}));
  EXPECT_EQ(run.exit_code, 0) << run.err;
  EXPECT_NE(run.out.find(R"("rmse_m": 0.25)"), std::string::npos) << run.out;
  const ProgramRun text = run_program(with({"--within", "3"}));
  EXPECT_NE(text.out.find("share_within                         0.5\n"), std::string::npos) << text.out;
  expect_refusal(with({"--pose", "0", "0", "3", "0", "0", "0", "2"}), "--pose: expected");
  write("far.obj", "v -1e12 -1 0\nv 1 -1 0\nv 1 1 0\nf 1 2 3\n");
  expect_refusal({"metric", "surface", folder() / "points.pcd", folder() / "far.obj"},
                 "far.obj: reaches beyond");

  write_surface_ply(folder() / "points.ply", {{{0, 0, 1}, {1, 0, 2}, {0, 1, 3}}, {}}, "");
  EXPECT_EQ(run_program({"metric", "surface", folder() / "points.ply", folder() / "plate.obj"}).exit_code, 0);
  expect_refusal({"metric", "surface", folder() / "points.ply", folder() / "points.ply"},
                 "points.ply: has no faces");

  for (const char* kind : {"pose", "project", "iou2d"})
    expect_refusal({"metric", kind, "--method", "exact"}, "--method is of iou3d");
  expect_refusal({"metric"}, "is none of");
  expect_refusal({"metric", "maps"}, "'maps' is none of iou3d, iou2d, project, pose, map, depth, surface");
  expect_refusal({"metric", "iou3d", "map", "a.bt", "b.bt"}, "map");
  expect_refusal({"metric", "map", folder() / "a.bt", folder() / "b.bt"}, "a.bt: cannot be read");
  expect_refusal({"metric", "depth", "a.png", "a.png", "--scale", "0"}, "--scale: expected more than 0");
  expect_refusal({"metric", "depth", "a.png", "a.png", "--id", "3"}, "--id requires --masks");
}

}  // namespace
}  // namespace uniquadric
