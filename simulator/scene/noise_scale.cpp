#include "simulator/scene/noise_scale.h"

#include <fmt/format.h>

#include <cassert>
#include <cmath>

#include "core/base/hash.h"

namespace uniquadric {
namespace {

void scale_imu(ImuCalibration& imu, double scale) {
  for (double* density : {&imu.gyroscope_noise_radps_rthz, &imu.gyroscope_walk_radps2_rthz,
                          &imu.accelerometer_noise_mps2_rthz, &imu.accelerometer_walk_mps3_rthz})
    *density *= scale;
}

}  // namespace

void scale_noise(Scene& scene, double scale) {
  assert(std::isfinite(scale) && scale >= 0);
  if (scale == 1) return;
  scene.noise_scale *= scale;
  scene.depth_noise.k *= scale;
  scene.depth_noise.disparity_sigma_px *= scale;
  scene.segmenter.boundary_sigma_px *= scale;
  scene.image_noise.sigma *= scale;
  double& electrons = scene.image_noise.electrons_per_level;
  electrons = scale > 0 ? electrons / (scale * scale) : 0;  // 0 is no shot noise
  if (scene.imu) scale_imu(scene.imu->calibration, scale);
  if (!scene.hash.empty())
    scene.hash = Hash().add("noise_scale").add(scene.hash).add(fmt::format("{}", scale)).hex();
}

}  // namespace uniquadric
