#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "core/base/files.h"
#include "simulator/scene/scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

Scene read_with(const std::string& sections) {
  const TempFolder temp;
  write_text(temp.path() / "scene.yaml",
             "rate_hz: 20\ncamera: {motion: {kind: static}}\n"
             "world:\n  - {name: floor, primitive: plane, size_m: [1, 1]}\n" +
                 sections);
  return load_scene(temp.path() / "scene.yaml");
}

TEST(ReadImaging, TakesEveryKey) {
  const Scene scene = read_with(
      "image: {samples: 1, gain: 1.5, exposure_s: 0.02, exposure_steps: 12, rolling_shutter_s: 0.03}\n"
      "image_noise: {sigma: 1, electrons_per_level: 40}\n"
      "depth_noise: {model: stereo, shadow: false, max_incidence_deg: 75, flying_pixels: 0.1}\n");
  EXPECT_EQ(scene.imaging.samples, 1);
  EXPECT_EQ(scene.imaging.gain, 1.5);
  EXPECT_EQ(scene.imaging.exposure_s, 0.02);
  EXPECT_EQ(scene.imaging.exposure_steps, 12);
  EXPECT_EQ(scene.imaging.rolling_shutter_s, 0.03);
  EXPECT_EQ(scene.image_noise.electrons_per_level, 40);
  EXPECT_FALSE(scene.depth_noise.shadow);
  EXPECT_EQ(scene.depth_noise.max_incidence_deg, 75);
  EXPECT_EQ(scene.depth_noise.flying_pixels, 0.1);
}

TEST(ReadImaging, RefusesWhatNoCameraDoes) {
  const std::vector<std::pair<std::string, std::string>> cases = {
      {"image: {samples: 2}", "expected 1 or 4"},
      {"image: {gain: 0}", "gain"},
      {"image: {exposure_s: -0.1}", "cannot be negative"},
      {"image: {exposure_s: 0.06}", "longer than a frame, 0.05 s"},
      {"image: {exposure_steps: 0}", "expected 1 to 256"},
      {"image: {exposure_steps: 257}", "expected 1 to 256"},
      {"image: {rolling_shutter_s: -0.1}", "cannot be negative"},
      {"image: {rolling_shutter_s: 0.06}", "longer than a frame, 0.05 s"},
      {"depth_noise: {smear_px: 0.4}", "smear_px: expected whole pixels"},
      {"image: {iso: 100}", "iso"},
      {"image_noise: {electrons_per_level: -1}", "cannot be negative"},
      {"depth_noise: {max_incidence_deg: 91}", "at most 90"},
      {"depth_noise: {flying_pixels: 1.5}", "expected 0 to 1"},
      {"segmenter: {outage_every_s: 0.5}", "outage_every_s: leaves no mask: each outage lasts 2 s"},
      {"image: {stamp_offset_s: -0.03}", "stamp_offset_s: is -0.03 s, more than half the time between two"},
      {"image: {stamp_jitter_s: 0.03}", "stamp_jitter_s: is 0.03 s, more than half the time between two"},
      {"image: {exposure_drift: 2}", "exposure_drift: expected at most 1, found 2"},
      {"image: {white_balance_drift: 2}", "white_balance_drift: expected at most 1"},
      {"depth_noise: {smear_px: 1e6}", "smear_px: expected at most 100, found 1000000"},
      {"depth_noise: {correlation_px: 101}", "correlation_px: expected at most 100"},
      {"depth_noise: {disparity_bias_px: -101}", "disparity_bias_px: expected -100 to 100"},
      {"depth_noise: {delay_s: 2}", "delay_s: expected at most 1"},
      {"depth_noise: {color_offset_m: -2}", "color_offset_m: expected -1 to 1, found -2"},
      {"depth_noise: {registration_error_px: [0, 101]}",
       "registration_error_px: expected -100 to 100 each, found 101"},
      {"depth_noise: {registration_error_px: [0.5, 0]}", "registration_error_px: expected whole pixels"},
      {"segmenter: {leak_px: 1e9}", "leak_px: expected at most 100"},
      {"segmenter: {boundary_sigma_px: 101}", "boundary_sigma_px: expected at most 100"},
      {"segmenter: {boundary_length_px: 101}", "boundary_length_px: expected 0.1 to 100"}};
  for (const auto& [section, said] : cases) {
    const std::string message = input_error([&] { read_with(section + "\n"); });
    EXPECT_NE(message.find(said), std::string::npos) << section << ": " << message;
    EXPECT_NE(message.find("scene.yaml:5"), std::string::npos) << message;
  }
  EXPECT_EQ(cases.size(), 28u);
}

// A key that changes no byte is named with what it needs; a level's own keys are not.
TEST(ReadSensors, WarnsOfKeysThatCountForNothing) {
  const auto said = [](const std::string& sections) {
    testing::internal::CaptureStderr();
    read_with(sections + "\n");
    return testing::internal::GetCapturedStderr();
  };
  const std::string nothing = ": counts for nothing, for it needs ";
  const std::vector<std::array<std::string, 4>> cases = {
      {"image", "exposure_steps: 4", "exposure_s above 0", "exposure_s: 0.01"},
      {"segmenter", "leak_px: 40", "leak_probability above 0", "leak_probability: 0.1"},
      {"segmenter", "latency_sigma_s: 0.1, latency_s: 0", "latency_s above 0", ""},
      {"segmenter", "outage_s: 1", "outage_every_s above 0", "outage_every_s: 5"},
      {"segmenter", "boundary_length_px: 9, boundary_sigma_px: 0", "boundary_sigma_px above 0", ""},
      {"depth_noise", "registered: false", "a color_offset_m", "color_offset_m: 0.02"},
      {"depth_noise", "dark_level: 30", "dark_dropout above 0", "dark_dropout: 0.1"}};
  for (const auto& [section, idle, needs, met] : cases) {
    const std::string key = section + '.' + idle.substr(0, idle.find(':'));
    const std::string text = said(section + ": {" + idle + "}");
    EXPECT_NE(text.find("scene.yaml:5: " + key + nothing + needs), std::string::npos) << text;
    EXPECT_EQ(std::ranges::count(text, '\n'), 1) << text;
    if (!met.empty()) {
      EXPECT_EQ(said(section + ": {" + idle + ", " + met + "}"), "");
    }
  }
  EXPECT_NE(said("depth_noise: {model: none, edge_dropout: 0.9}").find("model none has all depth"),
            std::string::npos);
  EXPECT_EQ(said("realism: real\nimage: {rolling_shutter_s: 0}\nsegmenter: {leak_probability: 0}"), "");
}

// What overflows, or asks for memory or time without end, is no sensor's.
TEST(ReadSensors, BoundsEveryNumber) {
  const std::vector<std::string> keys = {"image: {gain: X}",
                                         "image: {exposure_s: X}",
                                         "image: {rolling_shutter_s: X}",
                                         "image: {auto_exposure_level: X}",
                                         "image: {exposure_drift: X}",
                                         "image: {white_balance_drift: X}",
                                         "image: {stamp_offset_s: X}",
                                         "image: {stamp_jitter_s: X}",
                                         "image_noise: {sigma: X}",
                                         "image_noise: {electrons_per_level: X}",
                                         "depth_noise: {k: X}",
                                         "depth_noise: {baseline_m: X}",
                                         "depth_noise: {disparity_sigma_px: X}",
                                         "depth_noise: {disparity_step_px: X}",
                                         "depth_noise: {max_incidence_deg: X}",
                                         "depth_noise: {correlation_px: X}",
                                         "depth_noise: {disparity_bias_px: X}",
                                         "depth_noise: {smear_px: X}",
                                         "depth_noise: {dark_level: X}",
                                         "depth_noise: {color_offset_m: X}",
                                         "depth_noise: {registration_error_px: [X, 0]}",
                                         "depth_noise: {delay_s: X}",
                                         "depth_noise: {min_range_m: X}",
                                         "depth_noise: {max_range_m: X}",
                                         "segmenter: {boundary_sigma_px: X}",
                                         "segmenter: {boundary_length_px: X}",
                                         "segmenter: {latency_s: X}",
                                         "segmenter: {latency_sigma_s: X}",
                                         "segmenter: {leak_px: X}",
                                         "segmenter: {outage_every_s: X}",
                                         "segmenter: {outage_s: X}",
                                         "light: {sun_direction: [X, 0, 0]}",
                                         "imu: {rate_hz: X}",
                                         "imu: {gravity_mps2: X}",
                                         "imu: {gyroscope_noise_radps_rthz: X}",
                                         "imu: {accelerometer_walk_mps3_rthz: X}",
                                         "imu: {gyroscope_bias_radps: [0, X, 0]}",
                                         "imu: {accelerometer_bias_mps2: [X, 0, 0]}",
                                         "imu: {gyroscope_range_radps: X}",
                                         "imu: {accelerometer_range_mps2: X}",
                                         "imu: {mounting_error: {position_m: [0, 0, X]}}",
                                         "imu: {mounting_error: {rpy_deg: [X, 0, 0]}}",
                                         "imu: {body_from_imu: {position_m: [X, 0, 0]}}"};
  for (const std::string& key : keys)
    for (const char* value : {"1e30", "-1e30", ".nan", ".inf"}) {
      std::string section = key;
      section.replace(section.find('X'), 1, value);
      const std::string message = input_error([&] { read_with(section + "\n"); });
      EXPECT_NE(message.find("scene.yaml:5: "), std::string::npos) << section << ": " << message;
    }
}

// So small that a length or time between two of them is no number, and not 0, which is none.
TEST(ReadSensors, RefusesWhatIsAllButZero) {
  for (const char* section :
       {"segmenter: {outage_every_s: 1e-300}", "segmenter: {boundary_length_px: 1e-300}",
        "depth_noise: {correlation_px: 1e-300}", "depth_noise: {baseline_m: 1e-300}",
        "depth_noise: {disparity_step_px: 1e-300}", "image_noise: {electrons_per_level: 1e-300}",
        "light: {sun_direction: [1e-160, 0, 0]}", "imu: {rate_hz: 1e-300}"})
    EXPECT_NE(input_error([&] { read_with(std::string(section) + "\n"); }).find("scene.yaml:5: "),
              std::string::npos)
        << section;
  EXPECT_EQ(read_with("segmenter: {outage_every_s: 0}\n").segmenter.outage_every_s, 0);
}

TEST(ReadAppearance, TakesEveryKey) {
  const Scene scene = read_with(
      "  - {name: glass, primitive: box, size_m: [1, 1, 1], material: {shine: 0.4, depth_return: 0.1}}\n"
      "light: {shadows: true}\n");
  EXPECT_TRUE(scene.shadows);
  for (const Mesh& mesh : scene.world.at(1).meshes) {
    EXPECT_EQ(mesh.shine, 0.4f);
    EXPECT_EQ(mesh.depth_return, 0.1f);
  }
  for (const Mesh& mesh : scene.world.at(0).meshes) {
    EXPECT_EQ(mesh.shine, 0);
    EXPECT_EQ(mesh.depth_return, 1);
  }
  EXPECT_FALSE(read_with("").shadows);
}

TEST(ReadAppearance, RefusesSharesBeyondOne) {
  for (const char* key : {"shine", "depth_return"}) {
    const std::string message = input_error([&] {
      read_with(
          fmt::format("  - {{name: b, primitive: box, size_m: [1, 1, 1], material: {{{}: 1.5}}}}\n", key));
    });
    EXPECT_NE(message.find("scene.yaml:5"), std::string::npos) << message;
    EXPECT_NE(message.find("expected 0 to 1, found 1.5"), std::string::npos) << message;
  }
}

}  // namespace
}  // namespace uniquadric
