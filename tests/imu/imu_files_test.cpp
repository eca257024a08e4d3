#include <gtest/gtest.h>

#include <string>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "simulator/imu/imu.h"
#include "simulator/imu/imu_files.h"
#include "tests/simulator/scene_support.h"

namespace uniquadric {
namespace {

using scene_test::ScratchFolder;

const std::string kScene = R"(frames: 7
rate_hz: 30
camera: {motion: {kind: circle, center_m: [0, 0, 1], radius_m: 1, rate_degps: 30, facing: target, look_at_m: [0, 0, 1]}}
imu:
  rate_hz: 100
  camera_from_imu: {position_m: [0.1, 0, -0.05], rpy_deg: [0, 90, 0]}
  gyroscope_noise_radps_rthz: 0.001
  gyroscope_bias_radps: [0.01, 0, 0]
  accelerometer_range_mps2: 180
world:
  - {name: floor, primitive: plane, size_m: [2, 2], material: {texture_px: 16}}
)";

std::string refusal(const std::string& from, const std::string& to) {
  const ScratchFolder folder("imu_fault");
  std::string text = kScene;
  const auto at = text.find(from);
  EXPECT_NE(at, text.npos) << from;
  try {
    load_scene(folder.write("scene.yaml", text.replace(at, from.size(), to)));
  } catch (const InputError& error) {
    return error.what();
  }
  return "accepted";
}

TEST(ImuSection, SaysWhatTheRigIs) {
  const ScratchFolder folder("imu_section");
  const Scene scene = load_scene(folder.write("scene.yaml", kScene));
  ASSERT_TRUE(scene.imu);
  const ImuCalibration& model = scene.imu->calibration;
  EXPECT_EQ(model.rate_hz, 100);
  EXPECT_EQ(model.gyroscope_noise_radps_rthz, 0.001);
  EXPECT_EQ(model.accelerometer_noise_mps2_rthz, 2e-3);
  EXPECT_EQ(model.gravity_mps2, 9.81);
  EXPECT_EQ(scene.imu->gyroscope_bias_radps.x(), 0.01);
  EXPECT_EQ(scene.imu->accelerometer_range_mps2, 180);
  EXPECT_FALSE(scene.imu->gyroscope_range_radps);
  EXPECT_LT((model.camera_from_imu * Eigen::Vector3d(1, 0, 0) - Eigen::Vector3d(0.1, 0, -1.05)).norm(),
            1e-15);
}

TEST(ImuSection, MountsAlongTheBodyUnlessToldOtherwise) {
  const ScratchFolder folder("imu_mount");
  const auto forward_of = [&](const std::string& mount) -> Eigen::Vector3d {
    std::string text = kScene;
    const std::string given = "  camera_from_imu: {position_m: [0.1, 0, -0.05], rpy_deg: [0, 90, 0]}\n";
    text.replace(text.find(given), given.size(), mount);
    return load_scene(folder.write("scene.yaml", text)).imu->calibration.camera_from_imu *
           Eigen::Vector3d(1, 2, 3);
  };
  // Forward is the camera's z, left its -x, up its -y.
  EXPECT_LT((forward_of("") - Eigen::Vector3d(-2, -3, 1)).norm(), 1e-15);
  EXPECT_LT(
      (forward_of("  body_from_imu: {position_m: [0.5, 0, 0]}\n") - Eigen::Vector3d(-2, -3, 1.5)).norm(),
      1e-15);
  EXPECT_NE(
      refusal("  rate_hz: 100\n", "  body_from_imu: {}\n").find("give one of camera_from_imu, body_from_imu"),
      std::string::npos);
}

TEST(ImuSection, IsRefusedWithTheLineOfTheFault) {
  EXPECT_NE(refusal("rate_hz: 100", "rate_hz: 0").find(":5: imu.rate_hz: expected a number greater than 0"),
            std::string::npos);
  EXPECT_NE(refusal("rate_hz: 100", "rate_hz: 1e9").find(":5: imu.rate_hz: expected at most"),
            std::string::npos);
  EXPECT_NE(refusal("rthz: 0.001", "rthz: -1").find(":7: imu.gyroscope_noise_radps_rthz: cannot be negative"),
            std::string::npos);
  EXPECT_NE(
      refusal("[0.01, 0, 0]", "[.nan, 0, 0]").find(":8: imu.gyroscope_bias_radps[0]: expected a finite"),
      std::string::npos);
  EXPECT_NE(refusal("range_mps2: 180", "range: 180").find(":9: unknown key 'imu.accelerometer_range'"),
            std::string::npos);
}

TEST(ImuFiles, AreReadBackBitForBit) {
  const ScratchFolder folder("imu_files");
  const Scene scene = load_scene(folder.write("scene.yaml", kScene));
  write_imu_files(scene, 4, 7, folder.path(), folder.path());
  const auto samples = read_imu_csv(folder.path() / "imu.csv"),
             biases = read_imu_csv(folder.path() / "imu_bias.csv");
  ASSERT_EQ(samples.size(), 21u);  // 0.2 s
  ASSERT_EQ(biases.size(), 21u);
  EXPECT_EQ(samples.back().stamp_ns, 200'000'000);
  const auto true_biases = simulate_imu_biases(*scene.imu, 21, 4);
  const auto expected = simulate_imu(scene.camera_motion, *scene.imu, true_biases, 0, 21, 4);
  for (std::size_t k = 0; k < samples.size(); ++k) {
    EXPECT_EQ(samples[k].stamp_ns, expected[k].stamp_ns);
    EXPECT_EQ(samples[k].angular_velocity_radps, expected[k].angular_velocity_radps);
    EXPECT_EQ(samples[k].specific_force_mps2, expected[k].specific_force_mps2);
    EXPECT_EQ(biases[k].angular_velocity_radps, true_biases[k].gyroscope_radps);
    EXPECT_EQ(biases[k].specific_force_mps2, true_biases[k].accelerometer_mps2);
  }
}

TEST(ImuFiles, AreRefusedWithTheLineOfTheFault) {
  const ScratchFolder folder("imu_csv");
  const std::string header =
      "timestamp_ns,gyro_x_radps,gyro_y_radps,gyro_z_radps,accel_x_mps2,accel_y_mps2,accel_z_mps2\n";
  const auto message = [&](const std::string& text) -> std::string {
    try {
      read_imu_csv(folder.write("imu.csv", text));
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(message(header + "0,1,2,3,4,5,6\n"), "accepted");
  EXPECT_NE(message("0,1,2,3,4,5,6\n").find("imu.csv:1: expected the header"), std::string::npos);
  for (const auto& [wrong, at] : {std::pair("accel_x_g", 5), std::pair("gyro_y_degps", 3)}) {
    std::string text = header;
    const std::string name = at == 5 ? "accel_x_mps2" : "gyro_y_radps";
    text.replace(text.find(name), name.size(), wrong);
    const std::string said = message(text + "0,1,2,3,4,5,6\n");
    EXPECT_NE(said.find("imu.csv:1: expected the header timestamp_ns,"), std::string::npos) << said;
    EXPECT_NE(said.find("but column " + std::to_string(at) + " is '" + wrong + "'"), std::string::npos)
        << said;
  }
  EXPECT_NE(message(header + "0,1,2,3,4,5\n").find("imu.csv:2: expected 7 columns, found 6"),
            std::string::npos);
  EXPECT_NE(message(header + "0,1,2,nan,4,5,6\n").find("imu.csv:2: 'nan' is not a finite number"),
            std::string::npos);
  EXPECT_NE(message(header + "0.5,1,2,3,4,5,6\n").find("imu.csv:2: '0.5' is not a stamp"), std::string::npos);
  EXPECT_NE(message(header + "5,1,2,3,4,5,6\n5,1,2,3,4,5,6\n").find("imu.csv:3: stamp 5 does not come after"),
            std::string::npos);
}

TEST(ImuFiles, CalibrationStandsInTheSequenceIndex) {
  const ScratchFolder folder("imu_index");
  Sequence sequence;
  sequence.name = "x";
  sequence.rate_hz = 30;
  sequence.imu.emplace();
  sequence.imu->rate_hz = 123.4;
  sequence.imu->camera_from_imu = {exp_so3({0.1, 0.2, 0.3}), {1, 2, 3}};
  SequenceFrame frame;
  frame.rgb = "rgb/0.png";
  std::filesystem::create_directories(folder.path() / "rgb");
  folder.write("rgb/0.png", "");
  sequence.frames.push_back(frame);
  write_sequence_index(folder.path(), sequence);
  EXPECT_THROW(open_sequence(folder.path()), InputError) << "imu.csv is missing";
  write_imu_csv(folder.path() / "imu.csv", {{}});
  const Sequence back = open_sequence(folder.path());
  ASSERT_TRUE(back.imu);
  EXPECT_EQ(back.imu->rate_hz, 123.4);
  EXPECT_EQ(back.imu->gyroscope_noise_radps_rthz, sequence.imu->gyroscope_noise_radps_rthz);
  EXPECT_EQ(back.imu->camera_from_imu.rotation.coeffs(), sequence.imu->camera_from_imu.rotation.coeffs());
  EXPECT_EQ(back.imu->camera_from_imu.translation, sequence.imu->camera_from_imu.translation);
}

}  // namespace
}  // namespace uniquadric
