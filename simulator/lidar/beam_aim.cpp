#include "simulator/lidar/beam_aim.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "core/base/vector_clones.h"

namespace uniquadric {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

struct Direction {
  double x, y, z;
};

// Of a few degrees at most: within 1e-8 at 2 deg.
double small_tangent(double angle_rad) {
  return angle_rad * (1 + angle_rad * angle_rad / 3);
}

// A unit direction turned by small angles, to the left and up. Its length is 1 within 3e-9 up to 6 deg, and
// ranges do not depend on it.
Direction turned(const Direction& d, double left_rad, double up_rad) {
  const double level =
      std::max(std::sqrt(d.x * d.x + d.y * d.y), 1e-9);  // straight up, left is any direction
  const double left = small_tangent(left_rad), up = small_tangent(up_rad);
  const double square = left * left + up * up;
  const double scale = 1 - square * (0.5 - square * (0.375 - square * 0.3125));  // 1 / sqrt(1 + square)
  const double l = left / level, u = up / level;
  return {scale * (d.x - l * d.y - u * d.x * d.z), scale * (d.y + l * d.x - u * d.y * d.z),
          scale * (d.z + up * level)};
}

// Beams of one ray: in arrays, so that the compiler turns several at once.
UNIQUADRIC_VECTOR_CLONES
void turn_beams(const BeamBlock& beams, const BeamDraws& draws, double sigma_rad, BeamBlock& rays) {
  const auto count = static_cast<std::size_t>(beams.count);
  std::copy_n(beams.time_ns.begin(), count, rays.time_ns.begin());
  std::copy_n(beams.origin_x.begin(), count, rays.origin_x.begin());
  std::copy_n(beams.origin_y.begin(), count, rays.origin_y.begin());
  std::copy_n(beams.origin_z.begin(), count, rays.origin_z.begin());
  for (std::size_t i = 0; i < count; ++i) {
    const Direction d = turned({beams.x[i], beams.y[i], beams.z[i]}, sigma_rad * draws.aim_horizontal[i],
                               sigma_rad * draws.aim_vertical[i]);
    rays.x[i] = d.x;
    rays.y[i] = d.y;
    rays.z[i] = d.z;
  }
  rays.count = beams.count;
}

void put_ray(const BeamBlock& beams, std::size_t from, const Direction& direction, BeamBlock& rays) {
  const auto to = static_cast<std::size_t>(rays.count++);
  rays.time_ns[to] = beams.time_ns[from];
  rays.origin_x[to] = beams.origin_x[from];
  rays.origin_y[to] = beams.origin_y[from];
  rays.origin_z[to] = beams.origin_z[from];
  rays.x[to] = direction.x;
  rays.y[to] = direction.y;
  rays.z[to] = direction.z;
}

}  // namespace

void spread_beams(const LidarRig& rig, const BeamBlock& beams, const BeamDraws& draws, BeamBlock& rays) {
  const LidarBeam& beam = rig.beam;
  assert(beams.count * beam.rays() <= BeamBlock::kCapacity);
  const double sigma_rad = rig.noise.angle_sigma_deg * kDegree;
  if (beam.rays() == 1) return turn_beams(beams, draws, sigma_rad, rays);
  const auto place = [](int i, int n, double width_deg) {
    return ((i + 0.5) / n - 0.5) * width_deg * kDegree;
  };
  rays.count = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(beams.count); ++i)
    for (int row = 0; row < beam.vertical_rays; ++row)
      for (int column = 0; column < beam.horizontal_rays; ++column)
        put_ray(beams, i,
                turned({beams.x[i], beams.y[i], beams.z[i]},
                       sigma_rad * draws.aim_horizontal[i] +
                           place(column, beam.horizontal_rays, beam.horizontal_deg),
                       sigma_rad * draws.aim_vertical[i] + place(row, beam.vertical_rays, beam.vertical_deg)),
                rays);
}

}  // namespace uniquadric
