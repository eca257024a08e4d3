#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "simulator/scene/mesh_building.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

using scene_test::ScratchFolder;

const std::string kScene = R"(frames: 20
rate_hz: 25
camera:
  calibration: {width: 64, height: 48, fx: 50, fy: 50, cx: 31.5, cy: 23.5}
  motion:
    kind: spline
    look_at_m: [0, 0, 1]
    waypoints:
      - {time_s: 0, position_m: [-2, -2, 1]}
      - {time_s: 1, position_m: [2, -2, 1]}
depth_noise: {model: stereo, baseline_m: 0.1}
segmenter: {latency_s: 0.2}
light: {ambient: 0.4}
world:
  - {name: room, primitive: room, size_m: [6, 6, 3], furniture: 0, material: {texture_px: 64}}
objects:
  - id: 7
    name: block
    primitive: box
    size_m: [0.4, 0.2, 0.1]
    material: {texture_px: 64}
    motion: {kind: static, position_m: [0, 0, 1], rpy_deg: [0, 0, 90]}
  - id: 8
    name: other
    primitive: ball
    size_m: [0.2, 0.2, 0.2]
    segments: 4
    material: {texture_px: 64}
    motion: {kind: line, velocity_mps: [0.1, 0, 0], start: {position_m: [0, 1, 0.1]}, rolling_radius_m: 0.1}
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  return text.replace(at, from.size(), to);
}

std::string refusal(const std::filesystem::path& path) {
  try {
    load_scene(path);
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(SceneFile, SaysWhatTheSceneHolds) {
  const ScratchFolder folder("scene_content");
  const Scene scene = load_scene(folder.write("some.yaml", kScene));
  EXPECT_EQ(scene.name, "some");
  EXPECT_EQ(scene.frames, 20);
  EXPECT_EQ(scene.stamp_ns(3), 120'000'000);
  EXPECT_EQ(scene.camera.width, 64);
  EXPECT_EQ(scene.depth_noise.model, DepthNoise::Model::stereo);
  EXPECT_EQ(scene.depth_noise.baseline_m, 0.1);
  EXPECT_EQ(scene.segmenter.latency_s, 0.2);
  EXPECT_EQ(scene.ambient, 0.4);
  ASSERT_EQ(scene.world.size(), 1u);
  EXPECT_EQ(scene.world[0].id, 0);
  EXPECT_EQ(scene.world[0].motion.at(0).translation, Eigen::Vector3d(0, 0, 1.5));
  ASSERT_EQ(scene.objects.size(), 2u);
  const Body& block = scene.objects[0];
  EXPECT_EQ(block.id, 7);
  EXPECT_EQ(block.shape, "box");
  EXPECT_EQ(block.semi_axes_m, Eigen::Vector3d(0.2, 0.1, 0.05));
  EXPECT_LT((block.motion.at(0) * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0, 1, 1)).norm(), 1e-15);
}

// Who plans looks at no texture.
TEST(SceneFile, WithoutPaintIsTheSceneButForItsTextures) {
  const Scene painted = parse_scene(kScene, "scene.yaml"),
              plain = parse_scene(kScene, "scene.yaml", {}, Textures::plain);
  EXPECT_EQ(plain.hash, painted.hash);
  const auto colors = [](const cv::Mat& texture) {
    std::set<std::uint32_t> found;
    for (int i = 0; i < texture.rows; ++i)
      for (int j = 0; j < texture.cols; ++j) {
        const auto& c = texture.at<cv::Vec3b>(i, j);
        found.insert((std::uint32_t{c[0]} << 16) + (std::uint32_t{c[1]} << 8) + c[2]);
      }
    return found.size();
  };
  ASSERT_EQ(plain.objects.size(), 2u);
  for (std::size_t i = 0; i < plain.objects.size(); ++i)
    for (std::size_t k = 0; k < plain.objects[i].meshes.size(); ++k) {
      const Mesh &with = painted.objects[i].meshes[k], &without = plain.objects[i].meshes[k];
      EXPECT_EQ(without.positions, with.positions);
      EXPECT_EQ(without.texture.size(), with.texture.size());
      EXPECT_EQ(colors(without.texture), 1u);
      EXPECT_GT(colors(with.texture), 10u);
    }
}

TEST(SceneFile, StatesAnObjectsSymmetry) {
  const ScratchFolder folder("scene_symmetry");
  EXPECT_FALSE(load_scene(folder.write("scene.yaml", kScene)).objects[1].symmetry);
  const Scene scene = load_scene(
      folder.write("scene.yaml", replaced(kScene, "segments: 4", "segments: 4\n    symmetry: none")));
  EXPECT_EQ(scene.objects[1].symmetry, BodySymmetry::none);
}

TEST(SceneFile, SaysWhatObjectIsNotScored) {
  const ScratchFolder folder("scene_scored");
  const Scene scene = load_scene(
      folder.write("scene.yaml", replaced(kScene, "segments: 4", "segments: 4\n    scored: false")));
  EXPECT_TRUE(scene.objects[0].is_scored);
  EXPECT_FALSE(scene.objects[1].is_scored);
}

TEST(SceneFile, IsRefusedWithTheLineOfTheFault) {
  struct Fault {
    std::string from, to, message;
  };
  const std::vector<Fault> faults = {
      {"frames: 20", "frame: 20", ":1: unknown key 'frame'"},
      {"frames: 20", "frames: 0", ":1: frames: expected 1 to"},
      {"rate_hz: 25", "rate_hz: 0", ":2: rate_hz: expected a number greater than 0"},
      {"rate_hz: 25", "rate_hz: -25", ":2: rate_hz: expected a number greater than 0"},
      {"rate_hz: 25", "rate_hz: 1e9", ":2: rate_hz: expected at most"},
      {"rate_hz: 25", "rate_hz: 1e-300", ":2: rate_hz: expected at least 0.001 Hz"},
      {"frames: 20\nrate_hz: 25", "frames: 2000000\nrate_hz: 0.001",
       ":2: rate_hz: 2000000 frames last 1999999000 s, expected at most 1000000000 s"},
      {"rate_hz: 25", "rate_hz: [25", "malformed YAML"},
      {"kind: spline\n    look_at_m: [0, 0, 1]\n    waypoints:\n      - {time_s: 0, position_m: [-2, -2, "
       "1]}\n      - {time_s: 1, position_m: [2, -2, 1]}",
       "{kind: static, rpy_deg: [1e308, 0, 0]}", ":6: camera.motion: frame 0: pose is not finite"},
      {"rpy_deg: [0, 0, 90]", "rpy_deg: [1e308, 0, 0]",
       ":22: objects[0].motion: frame 0: pose is not finite"},
      {"velocity_mps: [0.1, 0, 0]", "velocity_mps: [1.7e308, 1.7e308, 0]",
       ":29: objects[1].motion: frame 0: pose is not finite"},
      {"furniture: 0,", "furniture: 0, pose: {rpy_deg: [1e308, 0, 0]},", ":15: world[0]: pose is not finite"},
      {"width: 64", "width: 1000000", ":4: camera.calibration.width: expected 1 to 16384 px"},
      {"position_m: [-2, -2, 1]", "position_m: [-2, .nan, 1]", ":9: "},
      {"position_m: [-2, -2, 1]", "position_m: [0, 0, 2]",
       ":9: camera.motion.waypoints[0]: cannot look at this point"},
      {"time_s: 1", "time_s: 0", ":10: camera.motion.waypoints[1]: time_s 0 does not follow 0"},
      {"time_s: 0, position_m: [-2, -2, 1]", "time_s: 0, position_m: [-2, -2, 1], hold_s: 2",
       ":10: camera.motion.waypoints[1]: time_s 1 does not follow 2, the end of the hold_s of the way-point"},
      {"{kind: static, position_m: [0, 0, 1], rpy_deg: [0, 0, 90]}", "{kind: toss, velocity_kmh: 4}",
       "velocity_kmh"},
      {"kind: spline", "kind: warp", ":6: camera.motion.kind: 'warp' is none of"},
      {"baseline_m: 0.1", "baseline_m: 0", ":11: depth_noise.baseline_m"},
      {"latency_s: 0.2", "delay_s: 0.2", ":12: unknown key 'segmenter.delay_s'"},
      {"ambient: 0.4", "sky_color: [0, 2, 0]", ":13: light.sky_color: expected red, green, blue from 0 to 1"},
      {"primitive: room, size_m: [6, 6, 3], furniture: 0", "primitive: street, size_m: [30, 30, 9]",
       ":15: world[0].size_m: a street measures at least 40 x 28 x 5 m"},
      {"primitive: room, size_m: [6, 6, 3], furniture: 0",
       "primitive: track, radius_m: 9, from_deg: 10, to_deg: 10", ":15: world[0].to_deg: expected more than"},
      {"primitive: room, size_m: [6, 6, 3], furniture: 0",
       "primitive: track, radius_m: 9, from_deg: 10, to_deg: 20, size_m: [1, 1, 1]",
       ":15: world[0].size_m: a track is measured by"},
      {"primitive: box", "primitive: street", ":20: objects[0].size_m: a street measures"},
      {"ambient: 0.4", "ambient: 1.4", ":13: light.ambient: expected 0 to 1"},
      {"furniture: 0", "furniture: 1000", ":15: world[0].furniture"},
      {"kind: spline\n    look_at_m: [0, 0, 1]\n    waypoints:\n      - {time_s: 0, position_m: [-2, -2, "
       "1]}\n      - {time_s: 1, position_m: [2, -2, 1]}",
       "{kind: circle, center_m: [0, 0, 2], radius_m: 1, rate_degps: 90, facing: target, look_at_m: [1, 0, "
       "0]}",
       ":6: camera.motion: frame 0: cannot look at this point"},
      {"id: 7", "id: 70000", ":17: objects[0].id: expected 1 to 65535"},
      {"id: 8", "id: 7", ":23: objects[1].id: 7 is the id of another object"},
      {"name: other", "name: block", ":24: objects[1].name: 'block' is the name of another object"},
      {"size_m: [0.4, 0.2, 0.1]", "size_m: [0.4, 0, 0.1]", ":20: objects[0].size_m: extents must be above 0"},
      {"size_m: [0.4, 0.2, 0.1]", "size_m: [0.4, 0.2]",
       ":20: objects[0].size_m: expected 3 numbers, found 2"},
      {"size_m: [0.2, 0.2, 0.2]", "size_m: [0.2, 0.2, 0.3]",
       ":26: objects[1].size_m: a ball has three equal extents"},
      {"primitive: box", "primitive: cone", ":19: objects[0].primitive: 'cone' is none of"},
      {"primitive: box", "primitive: room", ":19: objects[0].primitive: is for the world"},
      {"primitive: box", "mesh: none.obj", ": does not go with 'mesh'"},
      {"rpy_deg: [0, 0, 90]", "look_at_m: [0, 0, 0]", ":22: objects[0].motion.look_at_m: is for cameras"},
      {"rpy_deg: [0, 0, 90]", "quaternion_xyzw: [0, 0, 0, 2]",
       ":22: objects[0].motion.quaternion_xyzw: norm is 2"},
      {"position_m: [0, 0, 1], rpy", "position_m: [1e30, 0, 1], rpy",
       ":22: objects[0].motion: frame 0: is further than 1000000000 m from the origin"},
      {"velocity_mps: [0.1, 0, 0], start: {position_m: [0, 1, 0.1]}, rolling_radius_m: 0.1",
       "velocity_mps: [3e9, 0, 0]",
       ": objects[1].motion: frame 9: is further than 1000000000 m from the origin"},
      {"segments: 4", "sections: 4", ":27: unknown key 'objects[1].sections'"},
      {"segments: 4", "scored: maybe", ":27: objects[1].scored: "},
      {"segments: 4", "symmetry: round",
       ":27: objects[1].symmetry: expected box, revolution, sphere or none"},
      {"size_m: [0.4, 0.2, 0.1]", "size_m: [0.4, 0.2, 0.1]\n    symmetry: revolution",
       ":21: objects[0].symmetry: does not go with the extents"},
      {"  motion: {kind: line, velocity_mps: [0.1, 0, 0], start: {position_m: [0, 1, 0.1]}, "
       "rolling_radius_m: 0.1}",
       "  visible: true", ": objects[1]: missing key 'motion'"},
  };
  const ScratchFolder folder("scene_faults");
  int refused = 0;
  for (const Fault& fault : faults) {
    const auto path = folder.write("scene.yaml", replaced(kScene, fault.from, fault.to));
    const std::string message = refusal(path);
    EXPECT_NE(message.find(fault.message), message.npos) << "for '" << fault.to << "': " << message;
    EXPECT_EQ(message.find('\n'), message.npos) << message;
    refused += message != "accepted";
  }
  EXPECT_EQ(refused, 47);
  EXPECT_NE(refusal(folder.path() / "absent.yaml").find("cannot be read"), std::string::npos);
}

// "`marks` (10; ...) from 1 to 200" in the table of keys, and the reader's own words.
TEST(SceneFile, TheDocumentationSaysWhatAMaterialMayBe) {
  const std::string text = read_text(scene_test::kSource / "scenes/README.md");
  const ScratchFolder folder("scene_material");
  for (const std::string key : {"texture_px", "marks"}) {
    std::smatch said;
    ASSERT_TRUE(std::regex_search(text, said, std::regex("`" + key + "` \\([^)]*\\) from (\\d+) to (\\d+)")))
        << key;
    for (const int beyond : {std::stoi(said[1]) - 1, std::stoi(said[2]) + 1}) {
      const std::string value = std::to_string(beyond);
      const auto path = folder.write("scene.yaml", replaced(kScene, "{texture_px: 64}\n    motion",
                                                            "{" + key + ": " + value + "}\n    motion"));
      EXPECT_NE(refusal(path).find("objects[0].material." + key + ": expected " + said[1].str() + " to " +
                                   said[2].str() + ", found " + value),
                std::string::npos)
          << refusal(path);
    }
  }
}

TEST(SceneFile, AMeshTakesNothingOfAPrimitiveNorAPrimitiveOfAMesh) {
  const ScratchFolder folder("scene_mesh_keys");
  const std::string primitive = "primitive: box\n    size_m: [0.4, 0.2, 0.1]\n    material: {texture_px: 64}",
                    mesh = "mesh: part.obj";
  folder.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\nv 0 0 2\nf 1 2 3\nf 1 3 4\n");
  const auto refused = [&](const std::string& body, const std::string& key) {
    return refusal(folder.write("scene.yaml", replaced(kScene, primitive, body + "\n    " + key)));
  };
  for (const std::string key : {"primitive: box", "size_m: [1, 1, 1]", "material: {marks: 10}"})
    EXPECT_NE(refused(mesh, key).find(":20: objects[0]." + key.substr(0, key.find(':')) +
                                      ": does not go with 'mesh'"),
              std::string::npos)
        << refused(mesh, key);
  for (const std::string key : {"scale: 2", "mesh_rpy_deg: [0, 0, 90]", "symmetry: none"})
    EXPECT_EQ(refused(mesh, key), "accepted");
  EXPECT_NE(refused(mesh, "scale: 0").find(":20: objects[0].scale: expected a number greater than 0"),
            std::string::npos);
  for (const std::string key : {"scale: 2", "mesh_rpy_deg: [0, 0, 90]"})
    EXPECT_NE(refused(primitive, key).find(":22: unknown key 'objects[0]." + key.substr(0, key.find(':'))),
              std::string::npos)
        << refused(primitive, key);
}

TEST(SceneFile, WithAMeshThatCannotBeRenderedIsRefused) {
  const ScratchFolder folder("scene_bad_mesh");
  const std::string body = "primitive: box\n    size_m: [0.4, 0.2, 0.1]\n    material: {texture_px: 64}";
  const auto path = folder.write("scene.yaml", replaced(kScene, body, "mesh: part.obj"));
  EXPECT_NE(refusal(path).find(":19: objects[0].mesh: no such file"), std::string::npos);
  folder.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 1\n");
  EXPECT_NE(refusal(path).find("part.obj: "), std::string::npos) << "no faces";
  folder.write("part.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  EXPECT_NE(refusal(path).find(":19: objects[0].mesh: is flat"), std::string::npos);
}

TEST(SceneFile, KeepsTheLidarSectionForItsReader) {
  const ScratchFolder folder("scene_lidar");
  const Scene scene = load_scene(folder.write("scene.yaml", kScene + "lidar: {pattern: some, rate_hz: 0}\n"));
  ASSERT_TRUE(scene.lidar);
  EXPECT_EQ(scene.lidar->get<std::string>("pattern"), "some");
  EXPECT_THROW(scene.lidar->positive("rate_hz"), InputError);
  EXPECT_FALSE(load_scene(folder.write("scene.yaml", kScene)).lidar);
}

TEST(SceneFile, HashFollowsContentNotPlace) {
  const ScratchFolder here("scene_hash_here"), there("scene_hash_there");
  const std::string triangle = "v 0 0 0\nv 1 0 0\nv 0 1 1\nv 0 0 2\nf 1 2 3\nf 1 3 4\n";
  const std::string with_mesh =
      replaced(replaced(kScene, "primitive: box\n    size_m: [0.4, 0.2, 0.1]\n    material: {texture_px: 64}",
                        "mesh: part.obj"),
               "name: block", "name: part");
  here.write("part.obj", triangle);
  there.write("part.obj", triangle);
  const std::string hash = load_scene(here.write("scene.yaml", with_mesh)).hash;
  EXPECT_EQ(load_scene(there.write("scene.yaml", with_mesh)).hash, hash);
  EXPECT_NE(load_scene(there.write("scene.yaml", with_mesh + "# remark\n")).hash, hash);
  there.write("part.obj", triangle + "# remark\n");
  EXPECT_NE(load_scene(there.write("scene.yaml", with_mesh)).hash, hash);
}

// A key of a sensor may be meant for one that the scene has; a whole section says that it makes one.
TEST(SceneFile, WarnsOfASensorThatASetKeyMakes) {
  const auto said = [](const std::string& text, const ConfigOverride& value) {
    testing::internal::CaptureStderr();
    parse_scene(text, "scene.yaml", {value});
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(
      said(kScene, {"imu.mounting_error.rpy_deg", "[1, 2, 3]"}),
      "warning: scene.yaml: imu.mounting_error.rpy_deg (set, not the file's): makes the sensor, for the "
      "scene has no imu\n");
  EXPECT_NE(said(kScene, {"lidar.pattern", "vlp16"}).find("the scene has no lidar"), std::string::npos);
  EXPECT_EQ(said(kScene, {"imu", "{rate_hz: 100}"}), "");
  EXPECT_EQ(said(kScene + "imu: {}\n", {"imu.rate_hz", "100"}), "");
}

// The documentation's example is a scene that loads.
TEST(SceneFile, ExampleOfTheDocumentationLoads) {
  const std::string text = read_text(scene_test::kSource / "scenes/README.md");
  const auto begin = text.find("```yaml\n"), end = text.find("```", begin + 8);
  ASSERT_NE(begin, text.npos);
  const ScratchFolder folder("scene_example");
  const Scene scene = load_scene(folder.write("example.yaml", text.substr(begin + 8, end - begin - 8)));
  EXPECT_EQ(scene.objects.size(), 2u);
}

TEST(SceneFile, EverySceneHasAThumbnailAndAllAreSmall) {
  std::uintmax_t bytes = 0;
  unsigned scenes = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scene_test::kSource / "scenes"))
    if (entry.path().extension() == ".yaml") {
      const auto picture =
          entry.path().parent_path() / "thumbnails" / (entry.path().stem().string() + ".jpg");
      EXPECT_TRUE(std::filesystem::exists(picture)) << picture;
      bytes += std::filesystem::file_size(picture);
      ++scenes;
    }
  EXPECT_GE(scenes, 7u);
  EXPECT_LT(bytes, 40'000u * scenes);
}

TEST(SceneFile, OctreeStreetTakesThePapersRoute) {
  const Scene scene = load_scene(scene_test::kSource / "scenes/octree_street.yaml");
  EXPECT_EQ(scene.objects.size(), 2u);
  EXPECT_EQ(scene.lidar.value().get<std::string>("method"), "depth_octree");
}

TEST(SceneFile, MeshFromTheEnvironmentIsFoundOrNamed) {
  const auto path = scene_test::kSource / "scenes/ycb_table.yaml";
  const ScratchFolder empty("scene_no_data");
  ASSERT_EQ(setenv("UNIQUADRIC_DATA", empty.path().c_str(), 1), 0);
  const std::string message = refusal(path);
  EXPECT_NE(message.find(": objects[0].mesh: no such file: " + empty.path().string()), message.npos)
      << message;
  unsetenv("UNIQUADRIC_DATA");
  if (!std::filesystem::exists(scene_test::kData / "ycb"))
    GTEST_SKIP() << "no scanned meshes at " << scene_test::kData;
  const Scene scene = load_scene(path);
  ASSERT_EQ(scene.objects.size(), 5u);
  for (const Body& body : scene.objects) {
    const Eigen::AlignedBox3d box = tight_box(body.meshes);
    EXPECT_LT(box.center().norm(), 1e-7);
    EXPECT_LT((box.sizes() / 2 - body.semi_axes_m).norm(), 1e-7);
    EXPECT_FALSE(body.meshes.at(0).texture.empty());
  }
  const Eigen::Vector3d cube =
      2 * scene.objects[0].semi_axes_m;  // 57 mm by its maker; the scan is a millimetre off
  EXPECT_LT((cube - Eigen::Vector3d::Constant(0.0575)).cwiseAbs().maxCoeff(), 0.002);
}

}  // namespace
}  // namespace uniquadric
