// Bad input through the program itself: one line that names the culprit, exit code 2, nothing half-written.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <fstream>
#include <opencv2/core.hpp>
#include <thread>

#include "core/base/files.h"
#include "core/sequence/pcd.h"
#include "core/sequence/sequence.h"
#include "tests/harness/program.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

class Cli : public testing::Test {
 protected:
  const fs::path& folder() const { return temp_.path(); }
  fs::path out() const { return folder() / "out"; }
  fs::path write(const std::string& name, const std::string& text) const {
    fs::create_directories((folder() / name).parent_path());
    write_text(folder() / name, text);
    return folder() / name;
  }
  void expect_refusal(const std::vector<std::string>& arguments, const std::string& what) const {
    expect_refused(run_program(arguments), what);
    EXPECT_FALSE(fs::exists(out()));
    for (const auto& entry : fs::directory_iterator(folder()))
      EXPECT_FALSE(entry.path().string().ends_with(".partial")) << entry.path();
  }
  // The small scene with `find` replaced; the error must stand at the end of the replacement, or
  // `lines_after`.
  void expect_scene_refused(const std::string& find, const std::string& by, const std::string& what,
                            int lines_after = 0) const {
    std::string text = small_scene_yaml();
    const std::size_t begin = text.find(find);
    ASSERT_NE(begin, std::string::npos);
    text.replace(begin, find.size(), by);
    const fs::path scene = write("scene.yaml", text);
    const auto end = static_cast<std::ptrdiff_t>(begin + by.size());
    const auto line = std::count(text.begin(), text.begin() + end, '\n') + 1 + lines_after;
    expect_refusal({"simulate", scene, out()}, scene.string() + ":" + std::to_string(line) + ": " + what);
  }

 private:
  TempFolder temp_;
};

TEST_F(Cli, HelpFitsAScreenAndExitsZero) {
  for (const std::string command : {"simulate",
                                    "preview",
                                    "estimate",
                                    "evaluate",
                                    "bench",
                                    "report",
                                    "overlay",
                                    "info",
                                    "metric",
                                    "metric map",
                                    "metric depth",
                                    "metric surface",
                                    "trajectory",
                                    "compare",
                                    "import",
                                    "import tum",
                                    "import kitti-tracking",
                                    "import omd",
                                    "import euroc",
                                    "export",
                                    "perceive",
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

TEST_F(Cli, RefusesWhatItDoesNotKnow) {
  expect_refusal({"simulat"}, "there is no subcommand 'simulat'");
  expect_refusal({}, "subcommand");
  expect_refusal({"simulate", "a.yaml", out(), "--sed", "1"}, "--sed");
  expect_refusal({"simulate", "a.yaml", out(), "--frames", "0"}, "--frames");
  expect_refusal({"simulate", "a.yaml", out(), "--gl", "glx"}, "--gl: glx not in {osmesa,egl}");
  expect_refusal({"simulate", "a.yaml", out(), "--seed", "-5"}, "'-5' is no whole number");
  expect_refusal({"simulate", "a.yaml", out(), "--seed", "99999999999999999999"}, "is no whole number");
  for (const char* scale : {"-1", "nan", "inf", "x"})
    expect_refusal({"simulate", "a.yaml", out(), "--noise-scale", scale}, "is no number of at least 0");
  expect_refusal({"simulate", folder() / "none.yaml", out()}, "none.yaml: cannot be read");
  expect_refusal({"metric", "iou4d"}, "iou4d");
}

TEST_F(Cli, RefusesBadScenesByLine) {
  expect_scene_refused("frames: 4", "frames: [4", "malformed YAML", 1);  // noticed on the next line
  expect_scene_refused("rate_hz: 10", "rate_hz: 10\nframse: 3", "unknown key 'framse'");
  expect_scene_refused("rate_hz: 10", "rate_hz: 0", "rate_hz");
  expect_scene_refused("size_m: [0.4, 0.3, 0.2]", "size_m: [0.4, 0.0, 0.2]", "objects[0].size_m");
  expect_scene_refused("position_m: [0.5, 0, 0]", "position_m: [.nan, 0, 0]", "objects[0].motion");
  expect_scene_refused("time_s: 1, position_m: [0.5", "time_s: -1, position_m: [0.5", "objects[0].motion");
  expect_scene_refused("primitive: box\n    size_m: [0.4, 0.3, 0.2]", "mesh: none.obj", "objects[0]");
  expect_scene_refused("id: 2", "id: 1", "objects[1].id");
}

TEST_F(Cli, RefusesMeshesThatCannotBeDrawnAndSensorsWithoutARate) {
  const std::string box = "primitive: box\n    size_m: [0.4, 0.3, 0.2]", mesh = "mesh: part.obj";
  const auto refused = [&](const std::string& text, const std::string& what) {
    expect_refusal({"simulate", write("scene.yaml", text), out()}, what);
  };
  std::string with_mesh = small_scene_yaml();
  with_mesh.replace(with_mesh.find(box), box.size(), mesh);
  write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\n");
  refused(with_mesh, "part.obj: ");  // no faces
  const std::string gigapixel("\x89PNG\r\n\x1a\n\0\0\0\rIHDR\0\0\x80\0\0\0\x80\0\x08\x02\0\0\0\0\0\0\0", 33);
  write("part.png", gigapixel);
  write("part.mtl", "newmtl skin\nmap_Kd part.png\n");
  write("part.obj",
        "mtllib part.mtl\nusemtl skin\nv 0 0 0\nv 1 0 0\nv 0 1 1\nv 0 0 2\nvt 0 0\nf 1/1 2/1 3/1\nf 1/1 3/1 "
        "4/1\n");
  refused(with_mesh, "part.png: texture has 32768x32768 px");
  for (const std::string sensor : {"lidar: {pattern: vlp16, rate_hz: 0}", "imu: {rate_hz: 0}"})
    refused(small_scene_yaml() + sensor + "\n", "rate_hz: expected a number greater than 0");
}

TEST_F(Cli, RefusesBadSequences) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path rgb = data / "sequence/rgb/000001.png", given = data / "sequence/camera_given.tum";
  const std::string image = read_text(rgb), poses = read_text(given);
  const auto estimate_refused = [&](const std::string& what) {
    expect_refusal({"estimate", data / "sequence", out(), "--quiet"}, what);
  };
  const fs::path sam = write("sam.yaml", "schema: 1\nsegmentation: {source: sam}\n");
  expect_refusal({"estimate", data / "sequence", out(), "--variant", sam, "--quiet"}, "names no ONNX file");
  const fs::path depth = data / "sequence/depth/000001.png";
  const std::string depth_image = read_text(depth);
  write_text(depth, depth_image.substr(0, depth_image.size() / 2));
  estimate_refused("depth/000001.png: is a truncated image");
  write_text(depth, image);
  estimate_refused("depth/000001.png: expected a 16-bit grey image");
  write_png(depth, cv::Mat(10, 20, CV_16UC1, cv::Scalar(1000)));
  estimate_refused("depth/000001.png: is 20x10, the camera says ");
  write_text(depth, depth_image);

  write_text(given, poses + "2.0 0 0 nan 0 0 0 1\n");
  estimate_refused("camera_given.tum:6: 'nan' is not a finite number");
  write_text(given, poses + "0.05 0 0 0 0 0 0 1\n");
  estimate_refused("camera_given.tum:6: timestamp 0.05 does not come after");
  fs::remove(given);
  estimate_refused("camera_given.tum");
  estimate_refused(data.string());
  expect_refusal({"estimate", folder() / "none", out()}, "none: is not a folder");
}

TEST_F(Cli, RefusesBadVariantsAndBenches) {
  const fs::path variant = write("variant.yaml", "schema: 1\nbackedn: single_frame\n");
  expect_refusal({"estimate", folder() / "none", out(), "--variant", variant},
                 "variant.yaml:2: unknown key 'backedn'");
  const fs::path bench = write("bench.yaml", "scenes: [none.yaml]\nvariants: [v.yaml]\nseeds: [1]\n");
  expect_refusal({"bench", bench, out()}, "bench.yaml:1: scenes[0]: file");
  expect_refusal(
      {"bench", write("b.yaml", "seeds: []\nscenes: [bench.yaml]\nvariants: [bench.yaml]\n"), out()},
      "b.yaml:1: seeds: expected at least one");
  const auto refused = [&](const std::string& scenes, const std::string& why) {
    const std::string rest = "]\nvariants: [v.yaml]\nseeds: [1]\n";
    expect_refusal({"bench", write("c.yaml", "scenes: [" + scenes + rest), out()}, "c.yaml:1: " + why);
  };
  refused("{scene: bench.yaml, noise_scale: -1}", "scenes[0].noise_scale: expected 0 to 1000");
  refused("{scene: bench.yaml, noise_scale: 1, name: ..}",
          "scenes[0].name: names a folder that is there already");
  refused("{scene: bench.yaml, noise: 1}", "unknown key 'scenes[0].noise'");
  refused("{scene: bench.yaml, seeds: [2, 2]}", "scenes[0].seeds[1]: 2 stands twice");
  refused("bench.yaml, {scene: bench.yaml, noise_scale: 2}", "scenes[1]: the name 'bench' stands twice");
}

TEST_F(Cli, AVariantMayComeThroughAPipe) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path pipe = folder() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::jthread writer([&] { std::ofstream(pipe) << "schema: 1\npoints: {erode_px: 2}\n"; });
  const ProgramRun run = run_program({"estimate", data / "sequence", out(), "--variant", pipe, "--quiet"});
  writer.join();
  EXPECT_EQ(run.exit_code, 0) << run.err;
  const std::string options = read_text(out() / "run.yaml");
  EXPECT_NE(options.find("erode_px: 2"), std::string::npos);
  EXPECT_NE(options.find("name: \"piped\""), std::string::npos);
}

TEST_F(Cli, BenchWritesIntoNoForeignFolder) {
  const fs::path scene = write("small.yaml", small_scene_yaml());
  const fs::path variant = fs::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/single_frame_obb.yaml";
  const fs::path bench = write(
      "b.yaml", "scenes: [small.yaml]\nvariants: [" + variant.string() + "]\nseeds: [1]\noverlays: 1\n");
  const fs::path taken = folder() / "taken", precious = write("taken/precious.txt", "precious");
  expect_refusal({"bench", bench, taken}, "taken: is not empty and holds no results of bench");
  EXPECT_EQ(std::distance(fs::directory_iterator(taken), {}), 1);
  expect_refusal({"bench", bench, folder(), "--force"}, "holds the input");
  fs::create_symlink(folder() / "nothing", folder() / "link");
  expect_refusal({"bench", bench, folder() / "link"}, "link: is a link to ");
  write("cut_short/bench.yaml", "");  // as one that was ended before its report has it
  for (const auto& arguments :
       std::vector<std::vector<std::string>>{{"bench", bench, taken, "--force", "--quiet"},
                                             {"bench", bench, folder() / "cut_short", "--quiet"}}) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    EXPECT_TRUE(fs::exists(fs::path(arguments[2]) / "report.md"));
  }
  EXPECT_EQ(read_text(precious), "precious");
}

TEST_F(Cli, RefusesBadTracks) {
  write("truth/camera.tum", "0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n0.2 0 0 0 0 0 0 1\n");
  write("truth/objects.yaml", "schema: 1\nobjects:\n  - {id: 1, name: a, semi_axes_m: [1, .nan, 1]}\n");
  write("truth/objects/1.tum", "0 0 0 0 0 0 0 1\n");
  expect_refusal({"evaluate", folder() / "truth", folder() / "truth", out()},
                 "objects.yaml:3: objects[0].semi_axes_m[1]");
}

TEST_F(Cli, ARefusedOutputStaysAsItWas) {
  const fs::path scene = write("scene.yaml", small_scene_yaml());
  write("taken/precious.txt", "precious");
  const ProgramRun run = run_program({"simulate", scene, folder() / "taken", "--quiet"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.err.find("not empty"), std::string::npos);
  EXPECT_EQ(read_text(folder() / "taken/precious.txt"), "precious");
}

TEST_F(Cli, RefusesAMapOfTooManyCellsBeforeItDraws) {
  const auto refused = [&](const std::string& text) {
    expect_refusal({"simulate", write("scene.yaml", text), out()}, "map.resolution_m: cells of ");
    expect_refusal({"simulate", "", out()}, "(empty name): ");
  };
  refused(small_scene_yaml() + "map: {resolution_m: 1e-9}\n");
  refused(small_scene_yaml() + "map: {resolution_m: 1e-3}\n");  // 110 m^2: 110 million cells
  std::string wide = small_scene_yaml();                        // 0.1 m cells reach 3.2 km
  wide.replace(wide.find("size_m: [5, 5, 3]"), 17, "size_m: [9000, 5, 3]");
  refused(wide);
}

// --force replaces a result, never what the result is made of.
TEST_F(Cli, ForceNeverReplacesAnInput) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path sequence = data / "sequence", truth = data / "truth";
  const std::string before = folder_hash(folder());
  expect_refusal({"estimate", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"estimate", sequence, data, "--force"}, "data: holds the input");
  expect_refusal({"estimate", sequence, sequence / "out"}, "out: lies inside the input");
  expect_refusal({"estimate", sequence, out(), "--perception", sequence}, "sequence: is the input");
  expect_refusal({"perceive", sequence, data, "--force"}, "data: holds the input");
  expect_refusal({"evaluate", truth, truth, truth, "--force"}, "truth: is the input");
  expect_refusal({"overlay", sequence, truth, data, "--force"}, "data: holds the input");
  expect_refusal({"export", "tum", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"import", "tum", sequence, sequence, "--force"}, "sequence: is the input");
  expect_refusal({"simulate", scene, folder(), "--force"}, "holds the input");
  expect_refusal({"preview", scene, scene}, "scene.yaml: is the input");
  EXPECT_EQ(folder_hash(folder()), before);
}

TEST_F(Cli, AForeignFolderIsNotTakenForAKeptPerception) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  const fs::path precious = write("taken/precious.txt", "precious");
  expect_refusal({"estimate", data / "sequence", out(), "--quiet", "--perception", folder() / "taken"},
                 "taken: is not empty and holds no perception");
  EXPECT_EQ(read_text(precious), "precious");
  const fs::path kept = folder() / "kept";
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet"}).exit_code, 0);
  const ProgramRun again = run_program({"perceive", data / "sequence", kept, "--quiet", "--seed", "7"});
  EXPECT_EQ(again.exit_code, 0) << again.err;  // an older result is replaced
  const fs::path notes = write("kept/notes.txt", "mine");
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet", "--seed", "7"}).exit_code, 0)
      << "kept";
  expect_refusal({"perceive", data / "sequence", kept, "--quiet", "--seed", "8"},
                 "notes.txt: is no part of the kept perception");
  EXPECT_EQ(read_text(notes), "mine");
}

// Of the same sequence it is renewed, of another one it is a result like any other.
TEST_F(Cli, APerceptionOfAnotherSequenceIsReplacedByForceAlone) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), kept = folder() / "kept";
  const fs::path one = folder() / "one", two = folder() / "two";
  ASSERT_EQ(run_program({"simulate", scene, one, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"simulate", scene, two, "--quiet", "--seed", "1"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", one, kept, "--quiet"}).exit_code, 0);
  const std::string before = folder_hash(kept);
  expect_refusal({"estimate", two, out(), "--quiet", "--perception", kept},
                 "kept: holds the perception of another sequence (small)");
  expect_refusal({"perceive", two, kept, "--quiet"},
                 "kept: holds the perception of another sequence (small)");
  EXPECT_EQ(folder_hash(kept), before);
  const ProgramRun own =
      run_program({"estimate", one, out(), "--quiet", "--seed", "3", "--perception", kept});
  EXPECT_EQ(own.exit_code, 0) << own.err;
  EXPECT_NE(folder_hash(kept), before);
  const ProgramRun forced = run_program({"estimate", two, out(), "--quiet", "--force", "--perception", kept});
  EXPECT_EQ(forced.exit_code, 0) << forced.err;
  fs::remove_all(out());
  expect_refusal({"perceive", one, kept, "--quiet"}, "another sequence");  // it is of the other one now
}

// Perception samples too: another seed is another perception, unless it is told to keep its own.
TEST_F(Cli, SeedsOfTheBackEndCanShareAPerception) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  const fs::path kept = folder() / "kept", sequence = data / "sequence";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", sequence, kept, "--quiet", "--seed", "1"}).exit_code, 0);
  const std::string made = read_text(kept / "perception.yaml");
  const auto estimate = [&](std::vector<std::string> more) {
    std::vector<std::string> command = {"estimate", sequence,       out(), "--quiet",
                                        "--force",  "--perception", kept};
    command.insert(command.end(), more.begin(), more.end());
    const ProgramRun run = run_program(command);
    EXPECT_EQ(run.exit_code, 0) << run.err;
  };
  estimate({"--seed", "2", "--perception-seed", "1"});
  EXPECT_EQ(read_text(kept / "perception.yaml"), made);
  EXPECT_NE(read_text(fs::path(out()) / "run.yaml").find("\nseed: 2\nperception_seed: 1\n"),
            std::string::npos);
  estimate({"--seed", "2"});
  EXPECT_NE(read_text(kept / "perception.yaml"), made);
}

TEST_F(Cli, InfoSaysWhatAKeptPerceptionIsAndWhatIsWrongWithIt) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  const fs::path kept = folder() / "kept";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  ASSERT_EQ(run_program({"perceive", data / "sequence", kept, "--quiet"}).exit_code, 0);
  const ProgramRun whole = run_program({"info", kept, "--check"});
  EXPECT_EQ(whole.exit_code, 0) << whole.out << whole.err;
  for (const char* line : {"perception made by uniquadric", ", key ", "\nframes: 4 over 0.300 s; ",
                           "\nbody 1: in ", "\nbody 2: in ", "\n0 problems\n"})
    EXPECT_NE(whole.out.find(line), std::string::npos) << line << whole.out;
  std::string bytes = read_text(kept / "observations.bin");
  write("kept/notes.txt", "mine");
  const ProgramRun company = run_program({"info", kept, "--check"});
  EXPECT_NE(company.out.find("notes.txt: is no part of a kept perception\n1 problems"), std::string::npos)
      << company.out;
  bytes[bytes.size() / 2] ^= 1;
  write_text(kept / "observations.bin", bytes);
  EXPECT_EQ(run_program({"info", kept, "--check"}).exit_code, 2);
}

// The asynchronous tracker segments keyframes alone.
TEST_F(Cli, CheckFindsDamagedMasksThatNoEstimateReads) {
  const fs::path scene = write("scene.yaml", small_scene_yaml()), data = folder() / "data";
  ASSERT_EQ(run_program({"simulate", scene, data, "--quiet"}).exit_code, 0);
  fs::remove(data / "sequence/hashes.txt");
  const fs::path mask = data / "sequence/masks/000002.png";
  write_text(mask, read_text(mask).substr(0, 60));
  const ProgramRun run = run_program({"info", data / "sequence", "--check"});
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_NE(run.out.find("masks/000002.png: is a truncated image"), std::string::npos) << run.out;
}

TEST_F(Cli, AFullOutputIsAnError) {
  if (!fs::exists("/dev/full")) GTEST_SKIP() << "needs /dev/full";
  const fs::path scene = write("scene.yaml", small_scene_yaml());
  EXPECT_EQ(std::system((std::string(UNIQUADRIC_PROGRAM " info ") + scene.string() + " >/dev/full 2>" +
                         (folder() / "err").string())
                            .c_str()) >>
                8,
            2);
  EXPECT_NE(read_text(folder() / "err").find("cannot be written: No space left on device"),
            std::string::npos);
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

  expect_refusal({"metric"}, "is none of");
  expect_refusal({"metric", "maps"}, "'maps' is none of iou3d, iou2d, project, pose, map, depth, surface");
  expect_refusal({"metric", "iou3d", "map", "a.bt", "b.bt"}, "map");
  expect_refusal({"metric", "map", folder() / "a.bt", folder() / "b.bt"}, "a.bt: cannot be read");
  expect_refusal({"metric", "depth", "a.png", "a.png", "--scale", "0"}, "--scale: expected more than 0");
  expect_refusal({"metric", "depth", "a.png", "a.png", "--id", "3"}, "--id requires --masks");
}

}  // namespace
}  // namespace uniquadric
