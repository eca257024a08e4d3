#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

class ConfigNode;

/// What an inertial measurement unit reads at one instant, in its own frame.
struct ImuSample {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d specific_force_mps2 = Eigen::Vector3d::Zero();  ///< acceleration less gravity: up, at rest
};

/// Rate, place and noise of an IMU. Densities as EuRoC names them: white noise per root of the bandwidth, the
/// walk of the bias per root of time. The defaults are EuRoC's for its ADIS16448 (mav0/imu0/sensor.yaml;
/// Burri et al., "The EuRoC micro aerial vehicle datasets", IJRR 2016).
struct ImuCalibration {
  double rate_hz = 200;
  Pose camera_from_imu;
  double gyroscope_noise_radps_rthz = 1.6968e-4;     ///< [rad/s/sqrt(Hz)]
  double gyroscope_walk_radps2_rthz = 1.9393e-5;     ///< [rad/s^2/sqrt(Hz)]
  double accelerometer_noise_mps2_rthz = 2.0000e-3;  ///< [m/s^2/sqrt(Hz)]
  double accelerometer_walk_mps3_rthz = 3.0000e-3;   ///< [m/s^3/sqrt(Hz)]
  double gravity_mps2 = 9.81;                        ///< along the world's -z
};

/// The section `imu` of sequence.yaml; every key is required but the densities.
ImuCalibration read_imu_calibration(const ConfigNode& node);
std::string imu_yaml(const ImuCalibration& calibration);

/// Reads or changes the keys rate_hz, the four densities and gravity_mps2 of a map, as far as they are there;
/// leaves other keys to the caller. Throws InputError with file and line.
void read_imu_model(const ConfigNode& node, ImuCalibration& calibration);

/// imu.csv: timestamp_ns, gyro_x_radps, gyro_y_radps, gyro_z_radps, accel_x_mps2, accel_y_mps2, accel_z_mps2.
/// Reading throws InputError with the line for another header, a number that is malformed or not finite, or a
/// stamp that does not increase.
std::vector<ImuSample> read_imu_csv(const std::filesystem::path& path);
void write_imu_csv(const std::filesystem::path& path, const std::vector<ImuSample>& samples);

}  // namespace uniquadric
