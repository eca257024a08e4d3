#include "simulator/lidar/beam_casting.h"

#include <algorithm>
#include <cmath>

#include "core/base/random.h"
#include "core/base/vector_clones.h"
#include "simulator/lidar/beam_aim.h"
#include "simulator/lidar/beam_echoes.h"

namespace uniquadric {
namespace {

UNIQUADRIC_VECTOR_CLONES
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

void clear(BeamDraws& draws) {
  for (BeamDraws::Row* row : {&draws.aim_horizontal, &draws.aim_vertical, &draws.range, &draws.detection})
    row->fill(0);
}

// Which of the block's beams something rare happens to: the gaps between them are drawn.
class RareBeams {
 public:
  RareBeams(const BeamCasting& casting, std::int64_t from, const char* name, double probability)
      : stream_(casting.seed, name, static_cast<std::uint64_t>(casting.scan),
                static_cast<std::uint32_t>(from)),
        probability_(probability) {
    if (probability_ > 0)
      advance();
    else
      next_ = BeamBlock::kCapacity;
  }

  bool has(int beam) {
    if (beam < next_) return false;
    advance();
    return true;
  }
  RandomStream& stream() { return stream_; }

 private:
  void advance() {
    const double gap = std::floor(std::log(stream_.uniform()) / std::log1p(-probability_));
    next_ += 1 + static_cast<int>(std::min<double>(gap, BeamBlock::kCapacity));
  }

  RandomStream stream_;
  double probability_;
  int next_ = -1;
};

// In place: a point made elsewhere and copied would wait for its own parts to be written.
void put_point(const BeamCasting& casting, const BeamBlock& beams, int i, double range_m, float intensity,
               std::uint8_t tag, LidarPoint& point) {
  point.x = static_cast<float>(beams.origin_x[i] + range_m * beams.x[i]);
  point.y = static_cast<float>(beams.origin_y[i] + range_m * beams.y[i]);
  point.z = static_cast<float>(beams.origin_z[i] + range_m * beams.z[i]);
  point.offset_ns = static_cast<std::uint32_t>(beams.time_ns[i] - casting.start_ns);
  point.ring = beams.ring[i];
  point.intensity = intensity;
  point.tag = tag;
}

bool surface_point(const BeamCasting& casting, const BeamBlock& beams, int i, const EchoBlock& echoes,
                   LidarPoint& point, LidarPointTruth& truth) {
  const LidarNoise& noise = casting.rig.noise;
  const double range = echoes.measured_m[i];
  if (range < noise.min_range_m || range > noise.max_range_m) return false;
  put_point(casting, beams, i, range, reported_intensity(echoes.reflected[i]),
            static_cast<std::uint8_t>(echoes.number[i] << 4), point);
  truth = {static_cast<float>(echoes.range_m[i]), echoes.incidence_cos[i], echoes.instance[i],
           echoes.is_mixed[i] ? LidarPointTruth::Kind::mixed : LidarPointTruth::Kind::surface};
  return true;
}

}  // namespace

int cast_beams(const BeamCasting& casting, std::int64_t first, std::int64_t from, int count,
               LidarPoint* points, LidarPointTruth* truth) {
  const LidarRig& rig = casting.rig;
  BeamBlock beams, spread;
  WorldRays world_rays;
  RayBlock rays;
  BeamDraws draws;
  EchoBlock echoes;
  rig.pattern.fill(first + from, count, beams);
  if (rig.noise.is_random())
    draw_beams(casting.seed, static_cast<std::uint64_t>(casting.scan), static_cast<std::uint32_t>(from),
               count, draws);
  else
    clear(draws);
  const bool as_they_are = rig.beam.rays() == 1 && rig.noise.angle_sigma_deg == 0;
  if (!as_they_are) spread_beams(rig, beams, draws, spread);
  const BeamBlock& cast = as_they_are ? beams : spread;
  casting.path.place(cast, world_rays);
  to_single(casting, cast, world_rays, rays);
  casting.bodies.cast(rays);
  find_echoes(rig, rays, draws, echoes);

  RareBeams false_alarms(casting, from, "lidar/false_alarm", rig.noise.false_alarm);
  RareBeams crosstalk(casting, from, "lidar/crosstalk", rig.noise.crosstalk);
  const auto put_ghost = [&](int i, double range_m, LidarPoint& point, LidarPointTruth& its_truth) {
    put_point(casting, beams, i, range_m, 0, 0, point);
    its_truth = {static_cast<float>(range_m), 0, 0, LidarPointTruth::Kind::false_alarm};
  };
  int written = 0;
  for (int i = 0; i < count; ++i) {
    if (false_alarms.has(i)) {
      const double range_m = false_alarms.stream().uniform(rig.noise.min_range_m, rig.noise.max_range_m);
      put_ghost(i, range_m, points[written], truth[written]);
      ++written;
    } else if (crosstalk.has(i) && i > 0 && echoes.is_found[i - 1]) {
      put_ghost(i, echoes.measured_m[i - 1], points[written], truth[written]);
      ++written;
    } else if (echoes.is_found[i]) {
      written += surface_point(casting, beams, i, echoes, points[written], truth[written]);
    }
  }
  return written;
}

}  // namespace uniquadric
