#include "simulator/lidar/beam_casting.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <vector>

#include "core/base/random.h"
#include "simulator/lidar/echoes.h"

namespace uniquadric {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
using Draws = BeamBlock::Row<BeamDraws>;

struct Deflection {
  double horizontal_rad = 0, vertical_rad = 0;
};

// Of a few degrees at most: within 1e-8 at 2 deg.
double small_tangent(double angle_rad) {
  return angle_rad * (1 + angle_rad * angle_rad / 3);
}

// Copies beam `from` of `beams` to place `to` of `rays`, turned by small angles: to the left, and up.
void put_ray(const BeamBlock& beams, int from, const Deflection& deflection, BeamBlock& rays, int to) {
  rays.time_ns[to] = beams.time_ns[from];
  rays.origin_x[to] = beams.origin_x[from];
  rays.origin_y[to] = beams.origin_y[from];
  rays.origin_z[to] = beams.origin_z[from];
  const double x = beams.x[from], y = beams.y[from], z = beams.z[from];
  const double level = std::max(std::sqrt(x * x + y * y), 1e-9);  // straight up, left is any direction
  const double left_x = -y / level, left_y = x / level;
  const double up_x = -left_y * z, up_y = left_x * z, up_z = level;
  const double h = small_tangent(deflection.horizontal_rad), v = small_tangent(deflection.vertical_rad);
  const double dx = x + h * left_x + v * up_x, dy = y + h * left_y + v * up_y, dz = z + v * up_z;
  const double scale = 1 / std::sqrt(dx * dx + dy * dy + dz * dz);
  rays.x[to] = dx * scale;
  rays.y[to] = dy * scale;
  rays.z[to] = dz * scale;
}

// Every ray of every beam: the beam's error of aim and the ray's place in the beam.
void spread(const LidarRig& rig, const BeamBlock& beams, const Draws& draws, BeamBlock& rays) {
  const LidarBeam& beam = rig.beam;
  const double sigma = rig.noise.angle_sigma_deg * kDegree;
  const auto place = [](int i, int n, double width_deg) {
    return ((i + 0.5) / n - 0.5) * width_deg * kDegree;
  };
  rays.count = 0;
  for (int i = 0; i < beams.count; ++i)
    for (int row = 0; row < beam.vertical_rays; ++row)
      for (int column = 0; column < beam.horizontal_rays; ++column)
        put_ray(beams, i,
                {sigma * draws[i].aim_horizontal + place(column, beam.horizontal_rays, beam.horizontal_deg),
                 sigma * draws[i].aim_vertical + place(row, beam.vertical_rays, beam.vertical_deg)},
                rays, rays.count++);
}

void to_single(const BeamCasting& casting, const BeamBlock& beams, const WorldRays& from, RayBlock& to) {
  to.count = beams.count;
  const double start = static_cast<double>(casting.start_ns);
  const double scale = 1 / static_cast<double>(casting.end_ns - casting.start_ns);
  for (int i = 0; i < beams.count; ++i) {
    to.x[i] = static_cast<float>(from.x[i]);
    to.y[i] = static_cast<float>(from.y[i]);
    to.z[i] = static_cast<float>(from.z[i]);
    to.origin_x[i] = static_cast<float>(from.origin_x[i]);
    to.origin_y[i] = static_cast<float>(from.origin_y[i]);
    to.origin_z[i] = static_cast<float>(from.origin_z[i]);
    to.time[i] = static_cast<float>((static_cast<double>(beams.time_ns[i]) - start) * scale);
  }
}

// The hit of ray i, whose direction single precision has left a length of nearly 1: the range is in metres.
RayReturn return_of(const RayBlock& rays, int i, double share) {
  const double x = rays.x[i], y = rays.y[i], z = rays.z[i];
  const double length = 0.5 + 0.5 * (x * x + y * y + z * z);  // its square root within 1e-14
  const double cosine =
      rays.reflectivity[i] > 1 ? 1.0f : rays.incidence_cos[i];  // retro-reflectors: any angle
  return {rays.distance[i] * length, rays.reflectivity[i] * cosine * share, rays.incidence_cos[i],
          rays.instance[i]};
}

// `room` holds the returns of one beam.
std::optional<Echo> echo_of(const LidarRig& rig, const RayBlock& rays, int beam, const BeamDraws& draws,
                            std::vector<RayReturn>& room) {
  const double limit =
      detection_limit(rig.noise) * std::max(0.0, 1 + rig.noise.detection_sigma * draws.detection);
  const int n = rig.beam.rays();
  if (n == 1)
    return rays.distance[beam] < 0 ? std::nullopt : only_echo(return_of(rays, beam, 1), rig.noise, limit);
  room.clear();
  for (int i = beam * n; i < (beam + 1) * n; ++i)
    if (rays.distance[i] >= 0) room.push_back(return_of(rays, i, 1.0 / n));
  return reported_echo(room, rig.beam, rig.noise, limit);
}

double measured_range(const LidarRig& rig, const Echo& echo, const BeamDraws& draws) {
  const LidarNoise& noise = rig.noise;
  // A beam of several rays has its spread already.
  const double sigma =
      rig.beam.rays() > 1 ? noise.range_sigma_m : range_sigma(noise, echo.range_m, echo.incidence_cos);
  const double range = echo.range_m + sigma * draws.range;
  if (noise.quantum_m <= 0) return range;
  // A cast, as std::round is a call for this instruction set; what is negative falls below the least range.
  return static_cast<double>(static_cast<std::int64_t>(range / noise.quantum_m + 0.5)) * noise.quantum_m;
}

// Which of the block's beams report something that is not there, and how far: gaps between them are drawn.
class FalseAlarms {
 public:
  FalseAlarms(const BeamCasting& casting, std::int64_t from)
      : noise_(casting.rig.noise),
        stream_(casting.seed, "lidar/false_alarm", static_cast<std::uint64_t>(casting.scan),
                static_cast<std::uint32_t>(from)) {
    if (noise_.false_alarm > 0)
      advance();
    else
      next_ = BeamBlock::kCapacity;
  }

  std::optional<double> range_at(int beam) {
    if (beam < next_) return std::nullopt;
    advance();
    return stream_.uniform(noise_.min_range_m, noise_.max_range_m);
  }

 private:
  void advance() {
    const double gap = std::floor(std::log(stream_.uniform()) / std::log1p(-noise_.false_alarm));
    next_ += 1 + static_cast<int>(std::min<double>(gap, BeamBlock::kCapacity));
  }

  const LidarNoise& noise_;
  RandomStream stream_;
  int next_ = -1;
};

LidarPoint point_of(const BeamCasting& casting, const BeamBlock& beams, int i, double range_m) {
  LidarPoint point;
  point.x = static_cast<float>(beams.origin_x[i] + range_m * beams.x[i]);
  point.y = static_cast<float>(beams.origin_y[i] + range_m * beams.y[i]);
  point.z = static_cast<float>(beams.origin_z[i] + range_m * beams.z[i]);
  point.offset_ns = static_cast<std::uint32_t>(beams.time_ns[i] - casting.start_ns);
  point.ring = beams.ring[i];
  return point;
}

bool surface_point(const BeamCasting& casting, const BeamBlock& beams, int i, const Echo& echo,
                   const BeamDraws& draws, LidarPoint& point, LidarPointTruth& truth) {
  const LidarNoise& noise = casting.rig.noise;
  const double range = measured_range(casting.rig, echo, draws);
  if (range < noise.min_range_m || range > noise.max_range_m) return false;
  point = point_of(casting, beams, i, range);
  point.intensity = reported_intensity(echo.reflected);
  point.tag = static_cast<std::uint8_t>(std::min(echo.number, 3) << 4);
  truth = {static_cast<float>(echo.range_m), echo.incidence_cos, echo.instance,
           echo.mixed ? LidarPointTruth::Kind::mixed : LidarPointTruth::Kind::surface};
  return true;
}

}  // namespace

int cast_beams(const BeamCasting& casting, std::int64_t first, std::int64_t from, int count,
               LidarPoint* points, LidarPointTruth* truth) {
  const LidarRig& rig = casting.rig;
  BeamBlock beams, spread_beams;
  WorldRays world_rays;
  RayBlock rays;
  Draws draws;
  rig.pattern.fill(first + from, count, beams);
  if (rig.noise.is_random())
    draw_beams(casting.seed, static_cast<std::uint64_t>(casting.scan), static_cast<std::uint32_t>(from),
               {draws.data(), static_cast<std::size_t>(count)});
  const bool as_they_are = rig.beam.rays() == 1 && rig.noise.angle_sigma_deg == 0;
  if (!as_they_are) spread(rig, beams, draws, spread_beams);
  const BeamBlock& cast = as_they_are ? beams : spread_beams;
  casting.path.place(cast, world_rays);
  to_single(casting, cast, world_rays, rays);
  casting.bodies.cast(rays);

  FalseAlarms false_alarms(casting, from);
  std::vector<RayReturn> room;
  int written = 0;
  for (int i = 0; i < count; ++i) {
    if (const auto range = false_alarms.range_at(i)) {
      points[written] = point_of(casting, beams, i, *range);
      truth[written++] = {static_cast<float>(*range), 0, 0, LidarPointTruth::Kind::false_alarm};
    } else if (const auto echo = echo_of(rig, rays, i, draws[i], room)) {
      written += surface_point(casting, beams, i, *echo, draws[i], points[written], truth[written]);
    }
  }
  return written;
}

}  // namespace uniquadric
