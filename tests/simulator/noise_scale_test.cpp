#include "simulator/scene/noise_scale.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/sequence/sequence.h"
#include "simulator/lidar_files.h"
#include "tests/simulator/simple_scene.h"
#include "tests/simulator/simulate_quietly.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// The boxes as the sensors give them with their noise times `scale`; all else is alike. All frames' images,
// one below the other: outlines are smooth, a frame's has but few independent errors.
struct Observed {
  cv::Mat colour, depth_m, masks;
};

Observed observe(double scale, const fs::path& folder) {
  Scene scene = two_boxes();
  scene.depth_noise.edge_dropout = 0;
  scene.segmenter.miss_probability = 0;
  scale_noise(scene, scale);
  simulate(scene, quiet(), folder);
  const Sequence sequence = open_sequence(folder / "sequence");
  Observed observed;
  for (const SequenceFrame& frame : sequence.frames) {
    observed.colour.push_back(read_rgb(sequence, frame));
    observed.depth_m.push_back(read_depth(sequence, frame));
    observed.masks.push_back(read_masks(sequence, frame));
  }
  return observed;
}

double rms(const cv::Mat& a, const cv::Mat& b) {
  return cv::norm(a, b, cv::NORM_L2) / std::sqrt(static_cast<double>(a.total() * a.channels()));
}

TEST(NoiseScale, ErrorsGrowInProportion) {
  const TempFolder temp;
  const Observed exact = observe(0, temp.path() / "0"), once = observe(1, temp.path() / "1"),
                 twice = observe(2, temp.path() / "2");
  const double depth = rms(once.depth_m, exact.depth_m), colour = rms(once.colour, exact.colour);
  EXPECT_GT(depth, 0.005);
  EXPECT_NEAR(rms(twice.depth_m, exact.depth_m) / depth, 2, 0.05);  // the same numbers, whole millimetres
  EXPECT_GT(colour, 1);
  EXPECT_NEAR(rms(twice.colour, exact.colour) / colour, 2, 0.1);  // whole grey levels, 0 to 255
  const double moved = cv::countNonZero(once.masks != exact.masks);
  EXPECT_GT(moved, 50);
  EXPECT_NEAR(cv::countNonZero(twice.masks != exact.masks) / moved, 2, 0.3);  // whole pixels
}

TEST(NoiseScale, NothingLeavesTheTruth) {
  const TempFolder temp;
  const Observed exact = observe(0, temp.path() / "0");
  cv::Mat ids;
  for (int frame = 0; frame < 12; ++frame)
    ids.push_back(read_image(temp.path() / "0/truth/instances" / cv::format("%06d.png", frame)));
  EXPECT_EQ(cv::norm(exact.masks, ids, cv::NORM_INF), 0);
}

TEST(NoiseScale, ReachesEverySensorAndTheHash) {
  Scene scene = two_boxes();
  scene.hash = "some";
  scene.image_noise.electrons_per_level = 36;
  scene.imu.emplace();
  const Scene before = scene;
  scale_noise(scene, 1);
  EXPECT_EQ(scene.hash, "some");
  scale_noise(scene, 3);
  EXPECT_NE(scene.hash, "some");
  EXPECT_EQ(scene.noise_scale, 3);
  EXPECT_EQ(scene.depth_noise.k, 3 * before.depth_noise.k);
  EXPECT_EQ(scene.depth_noise.disparity_sigma_px, 3 * before.depth_noise.disparity_sigma_px);
  EXPECT_EQ(scene.depth_noise.disparity_step_px, before.depth_noise.disparity_step_px);
  EXPECT_EQ(scene.segmenter.boundary_sigma_px, 3 * before.segmenter.boundary_sigma_px);
  EXPECT_EQ(scene.segmenter.miss_probability, before.segmenter.miss_probability);
  EXPECT_EQ(scene.image_noise.electrons_per_level, 4);  // a variance of 9 times
  const ImuCalibration &imu = scene.imu->calibration, &imu_before = before.imu->calibration;
  EXPECT_EQ(imu.gyroscope_noise_radps_rthz, 3 * imu_before.gyroscope_noise_radps_rthz);
  EXPECT_EQ(imu.gyroscope_walk_radps2_rthz, 3 * imu_before.gyroscope_walk_radps2_rthz);
  EXPECT_EQ(imu.accelerometer_noise_mps2_rthz, 3 * imu_before.accelerometer_noise_mps2_rthz);
  EXPECT_EQ(imu.accelerometer_walk_mps3_rthz, 3 * imu_before.accelerometer_walk_mps3_rthz);
  Scene other = before;
  scale_noise(other, 2);
  EXPECT_NE(other.hash, scene.hash);
}

TEST(NoiseScale, OfASceneFileIsItsKey) {
  const TempFolder temp;
  const std::string text =
      "camera: {motion: {kind: static}}\nlidar: {pattern: vlp16}\n"
      "world: [{name: wall, primitive: plane, size_m: [1, 1]}]\n";
  const auto load = [&](const std::string& extra) {
    write_text(temp.path() / "scene.yaml", text + extra);
    return load_scene(temp.path() / "scene.yaml");
  };
  const Scene plain = load(""), half = load("noise_scale: 0.5\n");
  EXPECT_EQ(half.image_noise.sigma, plain.image_noise.sigma / 2);
  const LidarNoise lidar = lidar_of(half)->noise, plain_lidar = lidar_of(plain)->noise;
  EXPECT_EQ(lidar.range_sigma_m, plain_lidar.range_sigma_m / 2);
  EXPECT_EQ(lidar.divergence_deg, plain_lidar.divergence_deg / 2);
  EXPECT_EQ(lidar.detection_sigma, plain_lidar.detection_sigma / 2);
  EXPECT_EQ(lidar.quantum_m, plain_lidar.quantum_m);
  EXPECT_EQ(lidar.false_alarm, plain_lidar.false_alarm);
  EXPECT_THROW(load("noise_scale: -1\n"), InputError);
}

}  // namespace
}  // namespace uniquadric
