#include "simulator/lidar/beam_echoes.h"

#include <algorithm>
#include <vector>

#include "core/base/vector_clones.h"
#include "simulator/lidar/echoes.h"

namespace uniquadric {
namespace {

// Of ray i's direction, which single precision has left a length of nearly 1: ranges are in metres.
double length_of(const RayBlock& rays, int i) {
  const double x = rays.x[i], y = rays.y[i], z = rays.z[i];
  return 0.5 + 0.5 * (x * x + y * y + z * z);  // its square root within 1e-14
}

// Reflectivity times cosine; retro-reflectors send back at any angle.
double reflected_by(const RayBlock& rays, int i) {
  return rays.reflectivity[i] * (rays.reflectivity[i] > 1 ? 1.0 : double{rays.incidence_cos[i]});
}

double limit_of(double limit, const LidarNoise& noise, float draw) {
  return limit * std::max(0.0, 1 + noise.detection_sigma * draw);
}

double weak_bias(const LidarNoise& noise, double reflected) {
  return noise.weak_bias_m * (1 - std::min(1.0, reflected));
}

// To the nearest multiple: what is added leaves no bits for fractions. For up to 2^51 steps.
double quantised(double range_m, double quantum_m) {
  constexpr double kNoFractions = 0x1.8p52;
  return (range_m / quantum_m + kNoFractions - kNoFractions) * quantum_m;
}

UNIQUADRIC_VECTOR_CLONES
void quantise(const LidarNoise& noise, int count, EchoBlock& echoes) {
  if (noise.quantum_m > 0)
    for (int i = 0; i < count; ++i) echoes.measured_m[i] = quantised(echoes.measured_m[i], noise.quantum_m);
}

// Beams of one ray: in arrays, so that the compiler works on several at once. What nothing was hit for is not
// found, whatever its other numbers.
UNIQUADRIC_VECTOR_CLONES
void single_echoes(const LidarNoise& noise, const RayBlock& rays, const BeamDraws& draws, EchoBlock& echoes) {
  const double limit = detection_limit(noise);
  const RangeSpread spread(noise);
  for (int i = 0; i < rays.count; ++i) {
    const double range = rays.distance[i] * length_of(rays, i);
    echoes.range_m[i] = range;
    echoes.reflected[i] = reflected_by(rays, i);
    echoes.measured_m[i] = range + weak_bias(noise, echoes.reflected[i]) +
                           spread.sigma_m(range, rays.incidence_cos[i]) * draws.range[i];
  }
  for (int i = 0; i < rays.count; ++i)
    echoes.is_found[i] =
        rays.distance[i] >= 0 && received_strength(noise, echoes.range_m[i], echoes.reflected[i]) >=
                                     limit_of(limit, noise, draws.detection[i]);
  quantise(noise, rays.count, echoes);
  std::copy_n(rays.incidence_cos.begin(), rays.count, echoes.incidence_cos.begin());
  std::copy_n(rays.instance.begin(), rays.count, echoes.instance.begin());
  std::fill_n(echoes.is_mixed.begin(), rays.count, false);
  std::fill_n(echoes.number.begin(), rays.count, std::uint8_t{0});
}

// Beams of several rays, which have the spread of ranges over the beam already.
void merged_echoes(const LidarRig& rig, const RayBlock& rays, const BeamDraws& draws, EchoBlock& echoes) {
  const double limit = detection_limit(rig.noise);
  const int n = rig.beam.rays();
  std::vector<RayReturn> met;
  for (int beam = 0; beam * n < rays.count; ++beam) {
    met.clear();
    for (int i = beam * n; i < (beam + 1) * n; ++i)
      if (rays.distance[i] >= 0)
        met.push_back({rays.distance[i] * length_of(rays, i), reflected_by(rays, i) / n,
                       rays.incidence_cos[i], rays.instance[i]});
    const auto echo =
        reported_echo(met, rig.beam, rig.noise, limit_of(limit, rig.noise, draws.detection[beam]));
    echoes.is_found[beam] = echo.has_value();
    echoes.range_m[beam] = echo ? echo->range_m : 0;
    echoes.measured_m[beam] = echoes.range_m[beam] + rig.noise.range_sigma_m * draws.range[beam];
    if (!echo) continue;
    echoes.reflected[beam] = echo->reflected;
    echoes.measured_m[beam] += weak_bias(rig.noise, echo->reflected);
    echoes.incidence_cos[beam] = echo->incidence_cos;
    echoes.instance[beam] = echo->instance;
    echoes.is_mixed[beam] = echo->mixed;
    echoes.number[beam] = static_cast<std::uint8_t>(std::min(echo->number, 3));
  }
  quantise(rig.noise, rays.count / n, echoes);
}

}  // namespace

void find_echoes(const LidarRig& rig, const RayBlock& rays, const BeamDraws& draws, EchoBlock& echoes) {
  if (rig.beam.rays() == 1)
    single_echoes(rig.noise, rays, draws, echoes);
  else
    merged_echoes(rig, rays, draws, echoes);
}

}  // namespace uniquadric
