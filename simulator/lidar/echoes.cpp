#include "simulator/lidar/echoes.h"

#include <algorithm>

namespace uniquadric {
namespace {

// One pulse of the rays from..to, sorted by range.
Echo merged(std::span<const RayReturn> rays, const LidarNoise& noise) {
  Echo echo;
  double weight = 0, strongest = -1;
  for (const RayReturn& ray : rays) {
    const double strength = received_strength(noise, ray.range_m, ray.reflected);
    weight += strength;
    echo.range_m += strength * ray.range_m;
    echo.reflected += ray.reflected;
    if (strength > strongest) {
      strongest = strength;
      echo.incidence_cos = ray.incidence_cos;
      echo.instance = ray.instance;
    }
    echo.mixed = echo.mixed || ray.instance != rays.front().instance;
  }
  echo.strength = weight;
  echo.range_m = weight > 0 ? echo.range_m / weight : rays.front().range_m;
  return echo;
}

bool is_better(const Echo& echo, const Echo& than, LidarBeam::Return returned) {
  switch (returned) {
    case LidarBeam::Return::first:
      return false;
    case LidarBeam::Return::strongest:
      return echo.strength > than.strength;
    case LidarBeam::Return::last:
      return true;
  }
  return false;
}

}  // namespace

std::optional<Echo> reported_echo(std::span<RayReturn> returns, const LidarBeam& beam,
                                  const LidarNoise& noise, double limit) {
  std::sort(returns.begin(), returns.end(),
            [](const RayReturn& a, const RayReturn& b) { return a.range_m < b.range_m; });
  std::optional<Echo> best;
  int number = 0;
  for (std::size_t from = 0; from < returns.size();) {
    std::size_t to = from + 1;
    while (to < returns.size() && returns[to].range_m - returns[from].range_m <= beam.merge_m) ++to;
    Echo echo = merged(returns.subspan(from, to - from), noise);
    from = to;
    if (echo.strength < limit) continue;
    echo.number = number++;
    if (!best || is_better(echo, *best, beam.returned)) best = echo;
  }
  return best;
}

}  // namespace uniquadric
