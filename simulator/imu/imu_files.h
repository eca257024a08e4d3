#pragma once

#include <cstdint>
#include <filesystem>

#include "simulator/scene/scene.h"

namespace uniquadric {

/// Writes what the scene's IMU, if it has one, reads from the first frame to the last of `frames`: imu.csv to
/// the sequence folder, and its biases to the truth folder's imu_bias.csv (timestamp_ns, gyro_x_radps, ...,
/// accel_x_mps2, ...: the same columns).
void write_imu_files(const Scene& scene, std::uint64_t seed, std::int64_t frames,
                     const std::filesystem::path& sequence_folder, const std::filesystem::path& truth_folder);

}  // namespace uniquadric
