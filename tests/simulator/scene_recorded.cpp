#include <gtest/gtest.h>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/warning.h"
#include "simulator/scene/motion_reader.h"
#include "simulator/scene/spline.h"
#include "simulator/scene/spline_reader.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

Motion read(const std::string& yaml) {
  std::vector<std::filesystem::path> files;
  return read_motion(ConfigNode::parse(yaml, "motion.yaml"), {Mover::body, files});
}

TEST(RecordedMotion, IsReadFromAFileThatEntersTheScenesHash) {
  const scene_test::ScratchFolder folder("recorded");
  const auto scene = [&](double end) {
    folder.write("a.tum", "7 0 0 1 0 0 0 1\n8 0 0 " + std::to_string(end) + " 0 0 0 1\n");
    return load_scene(folder.write("scene.yaml",
                                   "camera: {motion: {kind: recorded, file: a.tum, start_s: 1}}\n"
                                   "world: [{name: w, primitive: plane, size_m: [1, 1]}]\n"));
  };
  const Scene one = scene(2), other = scene(3);
  EXPECT_NE(one.hash, other.hash);
  const double end = (1 + 5 * 3.0) / 6;  // of the smoothing kernel, the last pose standing once more
  EXPECT_LT((other.camera_motion.at(9).translation - Vector3d(0, 0, end)).norm(), 1e-12);
  EXPECT_LT((other.camera_motion.at(1.5).translation - Vector3d(0, 0, 2)).norm(), 1e-12);
  EXPECT_THROW(read("{kind: recorded, file: absent.tum}"), InputError);
  folder.write("a.tum", "7 0 0 1 0 0 0 1\n");
  EXPECT_THROW(load_scene(folder.path() / "scene.yaml"), InputError) << "one pose is no motion";
}

// Else the body rests throughout without a word.
TEST(RecordedMotion, WarnsOfARecordOutsideTheScenesTime) {
  const scene_test::ScratchFolder folder("recorded");
  folder.write("a.tum", "7 0 0 1 0 0 0 1\n8 0 0 2 0 0 0 1\n");
  const auto said = [&](const std::string& start_s) {
    const std::string motion = "{kind: recorded, file: a.tum, start_s: " + start_s + "}";
    testing::internal::CaptureStderr();
    load_scene(folder.write("scene.yaml",
                            "frames: 4\nrate_hz: 10\ncamera: {motion: {kind: static}}\n"
                            "objects: [{id: 1, name: b, primitive: box, size_m: [1, 1, 1], "
                            "motion: {kind: compose, parts: [" +
                                motion + "]}}]\n"));
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(said("1000").find("scene.yaml:4: objects[0].motion.parts[0].file: lasts from 1000 to 1001 s, "
                              "outside the scene's 0 to 0.3 s: nothing moves by it"),
            std::string::npos)
      << said("1000");
  EXPECT_NE(said("-1.1").find("lasts from -1.1 to "), std::string::npos);
  for (const char* within : {"0", "-0.9", "0.2"}) EXPECT_EQ(said(within), "") << within;
}

TEST(RecordedMotion, RefusesAGapThatWouldFillTheMemory) {
  EXPECT_THROW(recorded_motion({{0, {}}, {0.001, {}}, {0.002, {}}, {1e7, {}}}), InputError);
}

TEST(SplineMotion, WarnsOfOvershoot) {
  const std::string begin = "kind: spline\nwaypoints:\n- {time_s: 0, position_m: [0, 0, 0]}\n",
                    rest = "- {time_s: 10, position_m: [2, 0, 0]}\n";
  const auto warnings = [&](const std::string& middle) {
    const int before = warnings_given();
    testing::internal::CaptureStderr();
    read(begin + middle + rest);
    const std::string text = testing::internal::GetCapturedStderr();
    const int given = warnings_given() - before;
    EXPECT_EQ(text.find("motion.yaml:5: way-point 2: ") != text.npos, given > 0) << text;
    return given;
  };
  EXPECT_EQ(warnings("- {time_s: 1, position_m: [1.9, 0, 0]}\n"), 1);  // fast, then nine seconds for 0.1 m
  EXPECT_EQ(warnings("- {time_s: 5, position_m: [1, 0, 0]}\n"), 0);
  EXPECT_EQ(warnings("- {time_s: 1, position_m: [1.9, 0, 0], hold_s: 5}\n"), 0);
  EXPECT_EQ(warnings("- {time_s: 9, position_m: [0, 0, 0], rpy_deg: [0, 0, 90], hold_s: 0.1}\n"), 0);
}

// But for one body that drifts by 2 cm where two way-points at one place should be a hold.
TEST(SplineMotion, OfAShippedSceneDoesNotOvershoot) {
  int splines = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scene_test::kSource / "scenes")) {
    if (entry.path().extension() != ".yaml") continue;
    const ConfigNode root = ConfigNode::load(entry.path());
    const int before = warnings_given();
    const auto check = [&](const ConfigNode& motion, Mover mover) {
      if (motion.get<std::string>("kind") != "spline") return;
      read_spline(motion, mover);
      ++splines;
    };
    check(root.at("camera").at("motion"), Mover::camera);
    if (const auto objects = root.find("objects"))
      for (const ConfigNode& object : objects->items()) check(object.at("motion"), Mover::body);
    EXPECT_EQ(warnings_given() - before, entry.path().stem() == "table_push" ? 1 : 0) << entry.path();
  }
  EXPECT_GT(splines, 10);
}

}  // namespace
}  // namespace uniquadric
