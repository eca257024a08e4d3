// Bad input through the program itself: one line that names the culprit, exit code 2, nothing half-written.
#include <sys/stat.h>

#include <fstream>
#include <opencv2/core.hpp>
#include <thread>

#include "core/sequence/sequence.h"
#include "tests/harness/cli_fixture.h"

namespace uniquadric {
namespace {

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
  refused(with_mesh, "part.png: has 32768x32768 px, at most 8192 a side are read");
  for (const std::string sensor : {"lidar: {pattern: vlp16, rate_hz: 0}", "imu: {rate_hz: 0}"})
    refused(small_scene_yaml() + sensor + "\n", "rate_hz: expected a number greater than 0");
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
  estimate_refused("camera_given.tum:6: timestamp 0.05 comes before");
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
          "scenes[0].name: expected a name: not empty, no comma, quote, slash or control character, no = + - "
          "@ or dot first");
  refused("{scene: bench.yaml, noise: 1}", "unknown key 'scenes[0].noise'");
  refused("{scene: bench.yaml, set: 3}", "scenes[0].set: expected a map");
  refused("{scene: bench.yaml, seeds: [2, 2]}", "scenes[0].seeds[1]: 2 stands twice");
  refused("bench.yaml, {scene: bench.yaml, noise_scale: 2}", "scenes[1]: the name 'bench' stands twice");
}

// The scenes of a family are no files yet, so the bench's line is named.
TEST_F(Cli, NamesTheBenchsLineOfAValueThatItSets) {
  write("small.yaml", small_scene_yaml());
  write("v.yaml", "schema: 1\n");
  const auto refused = [&](const std::string& scene, const std::string& why) {
    const std::string text = "variants: [v.yaml]\nseeds: [1]\nscenes:\n  - " + scene + "\n";
    const fs::path bench = write("bench.yaml", text);
    expect_refusal({"bench", bench, out()}, bench.string() + ":4: scenes[0]" + why);
  };
  const auto of_family = [&](const std::string& set, const std::string& scene_set, const std::string& why) {
    refused("{family: room, set: {frames: 3" + set + "}, scene_set: {" + scene_set + "}}", why);
  };
  of_family("", "bad.key: 1", ".scene_set.bad.key: unknown key 'bad' (known: ");
  of_family("", "depth_noise: {bad: 1}", ".scene_set.depth_noise: unknown key 'depth_noise.bad'");
  of_family("", "depth_noise.bad: 1", ".scene_set.depth_noise.bad: unknown key 'depth_noise.bad'");
  of_family("", "depth_noise.k: [1]", ".scene_set.depth_noise.k: expected a number");
  of_family("", "image: {gain: 1e30}", ".scene_set.image.gain: expected at most 1000, found 1e+30");
  of_family("", "lidar.rate_hz: 10", ".scene_set.lidar: give one of pattern, csv (in room_1.yaml)");
  of_family("", "lidar: {pattern: vlp17}", ".scene_set.lidar.pattern: 'vlp17' is no scan pattern");
  of_family("", "name.first: 1", ".scene_set.name.first: there is no key 'first'");
  of_family("", "world: []", ".scene_set: has neither world nor objects");
  of_family(", bad: 1", "", ".set.bad: unknown key 'bad' (known: ");
  of_family(", difficulty: high", "", ".set.difficulty: expected a number");
  of_family(", realism: perfect", "", ".set.realism: 'perfect' is none of");
  refused("{family: room, set: {frames: 0}}", ".set.frames: expected 1 to 100000, found 0");
  refused("{scene: small.yaml, set: {bad.key: 1}}", ".set.bad.key: unknown key 'bad'");
  refused("{scene: small.yaml, set: {frames: -1}}", ".set.frames: expected 1 to ");
  refused("{scene: small.yaml, objects: ','}", ": objects: ',' has an empty item");
}

// Scenes are looked at several at a time.
TEST_F(Cli, NamesTheFirstOfSeveralFaultyScenes) {
  write("v.yaml", "schema: 1\n");
  const fs::path bench = write("bench.yaml",
                               "variants: [v.yaml]\nseeds: [1]\nscenes:\n"
                               "  - {family: room, set: {frames: 3}}\n"
                               "  - {family: tabletop, scene_set: {first: 1}}\n"
                               "  - {family: room, name: other, set: {frames: 3}, scene_set: {second: 1}}\n");
  expect_refusal({"bench", bench, out()}, bench.string() + ":5: scenes[1].scene_set.first: unknown key");
}

TEST_F(Cli, NamesTheSceneForItsOwnFaultsThoughABenchSetsValues) {
  const fs::path scene = write("small.yaml", small_scene_yaml() + "image:\n  gain: -1\n");
  const fs::path bench = write("bench.yaml",
                               "variants: [v.yaml]\nseeds: [1]\nscenes: [{scene: small.yaml, "
                               "set: {frames: 3}}]\n");
  write("v.yaml", "schema: 1\n");
  const std::string text = read_text(scene);
  expect_refusal({"bench", bench, out()}, scene.string() + ":" +
                                              std::to_string(std::count(text.begin(), text.end(), '\n')) +
                                              ": image.gain: expected a number greater than 0");
}

// Nobody writes to the pipe: a program that opened it would wait for ever.
TEST_F(Cli, RefusesPipesForFiles) {
  const fs::path pipe = folder() / "pipe";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"simulate", pipe, out()}, {"bench", pipe, out()}, {"trajectory", pipe, pipe}})
    expect_refused(run_program(arguments), pipe.string() + ": is not a regular file");
}

TEST_F(Cli, RefusesBadTracks) {
  write("truth/camera.tum", "0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n0.2 0 0 0 0 0 0 1\n");
  write("truth/objects.yaml", "schema: 1\nobjects:\n  - {id: 1, name: a, semi_axes_m: [1, .nan, 1]}\n");
  write("truth/objects/1.tum", "0 0 0 0 0 0 0 1\n");
  expect_refusal({"evaluate", folder() / "truth", folder() / "truth", out()},
                 "objects.yaml:3: objects[0].semi_axes_m[1]");
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

}  // namespace
}  // namespace uniquadric
