// What simulate() says of scenes that are not what their author may have meant.
#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/base/files.h"
#include "simulator/scene/named_motions.h"
#include "tests/simulator/simple_scene.h"
#include "tests/simulator/simulate_quietly.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

TEST(Simulate, ObjectsThatAreNotSeenOrHoldTheCameraAreNamed) {
  const TempFolder temp;
  const auto said = [&](const std::string& position) {
    const Scene scene = parse_scene(
        "frames: 1\ncamera: {motion: {kind: static, position_m: [0, 0, 1], look_at_m: [1, 0, 1]}}\n"
        "objects: [{id: 1, name: box, primitive: box, size_m: [1, 1, 1], motion: {kind: static, "
        "position_m: " +
            position + "}}]\n",
        "s.yaml");
    testing::internal::CaptureStderr();
    SimulateOptions options = quiet();
    options.force = true;
    simulate(scene, options, temp.path() / "out");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_NE(said("[0, 0, 1]").find("object box fills an image: is the camera inside it?"), std::string::npos);
  EXPECT_NE(said("[-3, 0, 1]").find("object box is in no image"), std::string::npos);
  EXPECT_EQ(said("[3, 0, 1]"), "");
}

TEST(Simulate, ObjectsThatBeginInsideEachOtherAreNamed) {
  const auto said = [](double x_m) {
    const TempFolder temp;
    Scene scene = two_boxes();
    scene.frames = 1;
    scene.objects[1].motion =
        static_motion(scene.objects[0].motion.at(0) * Pose{Eigen::Quaterniond::Identity(), {x_m, 0, 0}});
    testing::internal::CaptureStderr();
    simulate(scene, quiet(), temp.path() / "out");
    return testing::internal::GetCapturedStderr().find("begin inside each other") != std::string::npos;
  };
  EXPECT_TRUE(said(0.1));
  EXPECT_FALSE(said(3));
}

TEST(Simulate, EmptyDepthImagesAreCounted) {
  const TempFolder temp;
  Scene scene = two_boxes();
  const auto said = [&] {
    SimulateOptions options = quiet(2);
    options.force = true;
    options.frames = 3;
    testing::internal::CaptureStderr();
    simulate(scene, options, temp.path() / "out");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said(), "");
  const std::string visibility = read_text(temp.path() / "out/truth/instances/visibility.csv");
  scene.depth_noise.model = DepthNoise::Model::stereo;
  scene.depth_noise.disparity_bias_px = -50;
  EXPECT_EQ(said(), "warning: scene two_boxes: 3 of 3 depth images have no valid pixel\n");
  EXPECT_EQ(read_text(temp.path() / "out/truth/instances/visibility.csv"), visibility);
  scene.depth = false;
  EXPECT_EQ(said(), "");
}

TEST(Simulate, ObjectsThatACutLeavesAtRestAreNamedOnce) {
  const auto said = [](std::int64_t frames) {
    const TempFolder temp;
    const Scene scene = parse_scene(
        "frames: 8\nrate_hz: 10\n"
        "camera: {calibration: {width: 64, height: 48, fx: 50, fy: 50, cx: 31.5, cy: 23.5}, motion: {kind: "
        "static, position_m: [0, 0, 1], look_at_m: [1, 0, 1]}}\n"
        "objects:\n"
        "- {id: 1, name: late, primitive: box, size_m: [1, 1, 1], motion: {kind: toss, begins_s: 0.45, "
        "start: {position_m: [4, -1, 1]}}}\n"
        "- {id: 2, name: early, primitive: box, size_m: [1, 1, 1], motion: {kind: toss, begins_s: 0.15, "
        "start: {position_m: [4, 1, 1]}}}\n"
        "- {id: 3, name: still, primitive: box, size_m: [0.3, 0.3, 0.3], motion: {kind: static, position_m: "
        "[5, 0, 1]}}\n",
        "s.yaml");
    SimulateOptions options = quiet();
    options.frames = frames;
    testing::internal::CaptureStderr();
    simulate(scene, options, temp.path() / "out");
    return testing::internal::GetCapturedStderr();
  };
  const std::string begin = "warning: scene s: in the first ", end = " of its 8 frames these objects do not ";
  EXPECT_EQ(said(2), begin + "2" + end + "move yet: late, early\n");
  EXPECT_EQ(said(4), begin + "4" + end + "move yet: late\n");
  EXPECT_EQ(said(7), "");
  EXPECT_EQ(said(8), "");
}

TEST(Simulate, RefusesBadInputAndLeavesNothing) {
  const TempFolder temp;
  Scene scene = two_boxes();
  SimulateOptions options = quiet();
  options.frames = 0;
  EXPECT_NE(input_error([&] { simulate(scene, options, temp.path() / "out"); }).find("0 frames"),
            std::string::npos);
  scene.camera.distortion[0] = -1;
  EXPECT_NE(input_error([&] { simulate(scene, quiet(), temp.path() / "out"); }).find("distortion"),
            std::string::npos);
  EXPECT_TRUE(fs::is_empty(temp.path()));
}

}  // namespace
}  // namespace uniquadric
