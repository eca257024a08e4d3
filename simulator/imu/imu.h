#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "core/sequence/imu.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// What an IMU adds to the true values at one instant.
struct ImuBias {
  Eigen::Vector3d gyroscope_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d accelerometer_mps2 = Eigen::Vector3d::Zero();
};

/// Sample k is taken at this time, rounded to the nanosecond.
std::int64_t imu_stamp_ns(const ImuCalibration& calibration, std::int64_t sample);

/// Samples from 0 s to the first at or after `end_ns`: two surround each time in between.
std::int64_t imu_sample_count(const ImuCalibration& calibration, std::int64_t end_ns);

/// The biases of samples 0 to `samples` - 1: Brownian motion from the rig's initial ones, by random steps of
/// variance walk^2 dt. A longer run begins with the same values.
std::vector<ImuBias> simulate_imu_biases(const ImuRig& rig, std::int64_t samples, std::uint64_t seed);

/// The instant's true angular velocity and specific force (f = R^T (a - g), a at the IMU's own place), in the
/// IMU frame.
ImuSample true_imu_sample(const Motion& world_from_camera, const ImuCalibration& calibration,
                          std::int64_t stamp_ns);

/// Samples `from` to `to` - 1 of an IMU: true values, bias and white noise of variance density^2 rate, cut
/// off at the rig's range. `biases` are those of simulate_imu_biases with at least `to` items. Every sample
/// depends on (seed, sample) and its bias alone, so slices join to the whole.
std::vector<ImuSample> simulate_imu(const Motion& world_from_camera, const ImuRig& rig,
                                    const std::vector<ImuBias>& biases, std::int64_t from, std::int64_t to,
                                    std::uint64_t seed);

}  // namespace uniquadric
