#include "simulator/imu/imu.h"

#include <cassert>
#include <cmath>

#include "core/base/random.h"
#include "simulator/scene/curve.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

Vector3d normals(RandomStream& random) {
  const double x = random.normal(), y = random.normal(), z = random.normal();
  return {x, y, z};
}

Vector3d measured(const Vector3d& value, const Vector3d& bias, double density, double rate_hz,
                  const std::optional<double>& range, RandomStream random) {
  const Vector3d reading = value + bias + density * std::sqrt(rate_hz) * normals(random);
  return range ? Vector3d(reading.cwiseMax(-*range).cwiseMin(*range)) : reading;
}

}  // namespace

std::int64_t imu_stamp_ns(const ImuCalibration& calibration, std::int64_t sample) {
  return std::llround(static_cast<double>(sample) * 1e9 / calibration.rate_hz);
}

std::int64_t imu_sample_count(const ImuCalibration& calibration, std::int64_t end_ns) {
  auto last = static_cast<std::int64_t>(static_cast<double>(end_ns) * 1e-9 * calibration.rate_hz);
  while (last > 0 && imu_stamp_ns(calibration, last - 1) >= end_ns) --last;
  while (imu_stamp_ns(calibration, last) < end_ns) ++last;
  return last + 1;
}

std::vector<ImuBias> simulate_imu_biases(const ImuRig& rig, std::int64_t samples, std::uint64_t seed) {
  const double root_step = std::sqrt(1 / rig.calibration.rate_hz);
  RandomStream gyroscope(seed, "imu_gyroscope_bias"), accelerometer(seed, "imu_accelerometer_bias");
  ImuBias bias{rig.gyroscope_bias_radps, rig.accelerometer_bias_mps2};
  std::vector<ImuBias> biases;
  biases.reserve(static_cast<std::size_t>(samples));
  for (std::int64_t k = 0; k < samples; ++k) {
    biases.push_back(bias);
    bias.gyroscope_radps += rig.calibration.gyroscope_walk_radps2_rthz * root_step * normals(gyroscope);
    bias.accelerometer_mps2 +=
        rig.calibration.accelerometer_walk_mps3_rthz * root_step * normals(accelerometer);
  }
  return biases;
}

ImuSample true_imu_sample(const Motion& world_from_camera, const ImuCalibration& calibration,
                          std::int64_t stamp_ns) {
  const Kinematics imu = world_from_camera.kinematics(static_cast<double>(stamp_ns) * 1e-9) *
                         at_rest(calibration.camera_from_imu);
  const Vector3d gravity_mps2(0, 0, -calibration.gravity_mps2);
  return {stamp_ns, imu.angular_velocity_radps,
          imu.pose.rotation.conjugate() * (imu.acceleration_mps2 - gravity_mps2)};
}

std::vector<ImuSample> simulate_imu(const Motion& world_from_camera, const ImuRig& rig,
                                    const std::vector<ImuBias>& biases, std::int64_t from, std::int64_t to,
                                    std::uint64_t seed) {
  assert(0 <= from && from <= to && to <= std::ssize(biases));
  const ImuCalibration& model = rig.calibration;
  std::vector<ImuSample> samples;
  for (std::int64_t k = from; k < to; ++k) {
    ImuSample sample = true_imu_sample(world_from_camera, model, imu_stamp_ns(model, k));
    const ImuBias& bias = biases[static_cast<std::size_t>(k)];
    const auto draw = static_cast<std::uint64_t>(k);
    sample.angular_velocity_radps =
        measured(sample.angular_velocity_radps, bias.gyroscope_radps, model.gyroscope_noise_radps_rthz,
                 model.rate_hz, rig.gyroscope_range_radps, {seed, "imu_gyroscope", draw});
    sample.specific_force_mps2 =
        measured(sample.specific_force_mps2, bias.accelerometer_mps2, model.accelerometer_noise_mps2_rthz,
                 model.rate_hz, rig.accelerometer_range_mps2, {seed, "imu_accelerometer", draw});
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace uniquadric
