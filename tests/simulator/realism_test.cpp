#include "simulator/scene/realism.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "core/base/files.h"
#include "simulator/scene/scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr const char* kScene = R"(
rate_hz: 25
realism: {}
camera: {{motion: {{kind: static, position_m: [0, -2, 1], look_at_m: [0, 0, 0]}}}}
depth_noise: {{smear_px: 9}}
imu: {{rate_hz: 200}}
lidar: {{pattern: livox_avia}}
world: [{{name: room, primitive: room, size_m: [5, 5, 3]}}]
)";

Scene scene_at(const std::string& level) {
  return parse_scene(fmt::format(kScene, level), "scene.yaml");
}

TEST(Realism, EveryLevelLoadsAndIdealIsTheDefault) {
  const Scene ideal = scene_at("ideal"), none = parse_scene(R"(
camera: {motion: {kind: static, position_m: [0, -2, 1], look_at_m: [0, 0, 0]}}
world: [{name: room, primitive: room, size_m: [5, 5, 3]}]
)",
                                                            "scene.yaml");
  EXPECT_EQ(ideal.depth_noise.model, none.depth_noise.model);
  EXPECT_EQ(ideal.imaging.rolling_shutter_s, 0);
  double before_px = 0;
  for (const char* level : {"mild", "real", "harsh"}) {
    const Scene scene = scene_at(level);
    EXPECT_EQ(scene.depth_noise.model, DepthNoise::Model::stereo);
    EXPECT_GT(scene.depth_noise.correlation_px, before_px) << level;  // each level is harsher
    before_px = scene.depth_noise.correlation_px;
    EXPECT_FALSE(scene.imu->mounting_error.rotation.isApprox(Eigen::Quaterniond::Identity())) << level;
  }
}

TEST(Realism, HarshAloneLosesTheTimesOfPoints) {
  for (const char* level : {"ideal", "mild", "real"})
    EXPECT_TRUE(scene_at(level).lidar->get<bool>("point_times", true)) << level;
  EXPECT_FALSE(scene_at("harsh").lidar->get<bool>("point_times", true));
}

TEST(Realism, WhatTheSceneSaysItselfCounts) {
  EXPECT_EQ(scene_at("real").depth_noise.smear_px, 9);
}

// What the level sets of another model would count for nothing.
TEST(Realism, AModelOfTheScenesOwnStaysWithoutAWarning) {
  const std::string text = fmt::format(kScene, "real");
  const auto said = [&](const std::string& noise) {
    testing::internal::CaptureStderr();
    parse_scene(std::string(text).replace(text.find("{smear_px: 9}"), 13, noise), "scene.yaml");
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(said("{model: proportional, k: 0.01}"), "");
  EXPECT_NE(said("{model: proportional, baseline_m: 0.1}")
                .find("scene.yaml:5: depth_noise.baseline_m: counts for model stereo alone, and the model is "
                      "proportional"),
            std::string::npos);
  EXPECT_NE(said("{k: 0.01}").find("depth_noise.k: counts for model proportional alone"), std::string::npos);
}

// A sensor that the scene turns in another way than the level would.
TEST(Realism, AMountingErrorOfTheScenesOwnStays) {
  for (const std::string turn : {"quaternion_xyzw: [0, 0, 0, 1]", "rpy_deg: [0, 0, 0]"}) {
    std::string text = fmt::format(kScene, "harsh");
    text.replace(text.find("imu: {"), 6, "imu: {mounting_error: {" + turn + "}, ");
    EXPECT_TRUE(parse_scene(text, "scene.yaml")
                    .imu->mounting_error.rotation.isApprox(Eigen::Quaterniond::Identity()));
  }
}

TEST(Realism, SharesOfAFrameFollowTheRate) {
  EXPECT_NEAR(scene_at("real").imaging.rolling_shutter_s, 0.45 / 25, 1e-12);
}

TEST(Realism, SensorsThatAreNotThereAreNotAdded) {
  const Scene scene = parse_scene(R"(
realism: harsh
camera: {motion: {kind: static, position_m: [0, -2, 1], look_at_m: [0, 0, 0]}}
world: [{name: room, primitive: room, size_m: [5, 5, 3]}]
)",
                                  "scene.yaml");
  EXPECT_FALSE(scene.imu || scene.lidar);
}

TEST(Realism, AnUnknownLevelIsNamedWithItsLine) {
  EXPECT_NE(input_error([] { scene_at("awful"); }).find("scene.yaml:3: realism"), std::string::npos);
}

TEST(Realism, ASectionThatIsNoMapIsBlamedAndNotTheLevel) {
  const auto message = [](const std::string& section) {
    return input_error([&] { parse_scene(fmt::format(kScene, "real") + section, "scene.yaml"); });
  };
  EXPECT_EQ(message("segmenter: none\n"), "scene.yaml:9: segmenter: expected a map, found none");
  EXPECT_EQ(message("image: [1]\n"), "scene.yaml:9: image: expected a map, found [1]");
  EXPECT_NO_THROW(parse_scene(fmt::format(kScene, "real") + "segmenter:\n", "scene.yaml"));
}

TEST(Realism, AValueThatDoesNotFitTheSceneIsTheLevels) {
  const std::string slow = std::string(fmt::format(kScene, "harsh")).replace(1, 11, "rate_hz: 0.3");
  EXPECT_NE(input_error([&] {
              parse_scene(slow, "scene.yaml");
            }).find("scene.yaml:3: realism harsh.depth_noise.delay_s: "),
            std::string::npos);
}

// The page that documents the levels has a row for each key, with these values.
TEST(Realism, ThePageIsTheTable) {
  const std::string page = read_text(UNIQUADRIC_SOURCE_DIR "/scenes/realism.md");
  for (const RealismRow& row : realism_rows()) {
    const auto shown = [](std::string_view value) { return std::string(value.empty() ? "-" : value); };
    const std::string line =
        fmt::format("| `{}`{} | {} | {} | {} | {} |\n", row.key, row.in_frames ? ", in frames" : "",
                    shown(row.mild), shown(row.real), shown(row.harsh), row.source);
    EXPECT_NE(page.find(line), std::string::npos) << line;
  }
}

}  // namespace
}  // namespace uniquadric
