#include "simulator/imu/imu_files.h"

#include "simulator/imu/imu.h"

namespace uniquadric {

void write_imu_files(const Scene& scene, std::uint64_t seed, std::int64_t frames,
                     const std::filesystem::path& sequence_folder,
                     const std::filesystem::path& truth_folder) {
  if (!scene.imu) return;
  const ImuRig& rig = *scene.imu;
  const std::int64_t samples = imu_sample_count(rig.calibration, scene.stamp_ns(frames - 1));
  const std::vector<ImuBias> biases = simulate_imu_biases(rig, samples, seed);
  write_imu_csv(sequence_folder / "imu.csv",
                simulate_imu(scene.camera_motion, rig, biases, 0, samples, seed));
  std::vector<ImuSample> truth;
  for (std::int64_t k = 0; k < samples; ++k) {
    const ImuBias& bias = biases[static_cast<std::size_t>(k)];
    truth.push_back({imu_stamp_ns(rig.calibration, k), bias.gyroscope_radps, bias.accelerometer_mps2});
  }
  write_imu_csv(truth_folder / "imu_bias.csv", truth);
}

}  // namespace uniquadric
