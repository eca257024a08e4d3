#include "simulator/lidar/lidar_scan.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include "core/base/error.h"
#include "core/base/threads.h"
#include "simulator/lidar/beam_casting.h"

namespace uniquadric {
namespace {

// Moves the points of the blocks, each at the place of its first beam, together.
void close_gaps(const std::vector<int>& counts, std::int64_t beams_a_block, LidarScan& scan) {
  std::size_t end = 0;
  for (std::size_t block = 0; block < counts.size(); ++block) {
    const auto from = static_cast<std::ptrdiff_t>(block * static_cast<std::size_t>(beams_a_block));
    const auto to = static_cast<std::ptrdiff_t>(end);
    if (from != to) {
      std::copy_n(scan.points.begin() + from, counts[block], scan.points.begin() + to);
      std::copy_n(scan.truth.begin() + from, counts[block], scan.truth.begin() + to);
    }
    end += static_cast<std::size_t>(counts[block]);
  }
  scan.points.resize(end);
  scan.truth.resize(end);
}

void for_each_block(std::int64_t blocks, int threads, const std::function<void(std::int64_t)>& work) {
  if (threads == 1) {
    for (std::int64_t block = 0; block < blocks; ++block) work(block);
    return;
  }
  tbb::task_arena arena(threads_to_use(threads));
  arena.execute([&] {
    tbb::parallel_for(tbb::blocked_range<std::int64_t>(0, blocks), [&](const auto& range) {
      for (std::int64_t block = range.begin(); block < range.end(); ++block) work(block);
    });
  });
}

}  // namespace

std::int64_t LidarRig::start_ns(std::int64_t scan) const {
  return std::llround(static_cast<double>(scan) * 1e9 / rate_hz);
}

PoseAt lidar_path(const Motion& world_from_camera, const LidarRig& rig) {
  return [world_from_camera, camera_from_lidar = rig.camera_from_lidar](double time_s) {
    return world_from_camera.at(time_s) * camera_from_lidar;
  };
}

LidarScan take_scan(const RayCaster& caster, const LidarRig& rig, const PoseAt& world_from_lidar,
                    std::int64_t scan, std::uint64_t seed, int threads) {
  const std::int64_t start = rig.start_ns(scan), end = rig.start_ns(scan + 1);
  const std::int64_t first = rig.pattern.first_at(start), beams = rig.pattern.first_at(end) - first;
  if (beams <= 0)
    throw InputError(
        fmt::format("lidar {}: no beam falls into scan {} of {} Hz", rig.pattern_name, scan, rig.rate_hz));
  const SensorPath path(world_from_lidar, start, end);
  const CasterScan bodies = caster.open(path.origin(), start, end);
  const BeamCasting casting{rig, path, bodies, seed, scan, start, end};
  LidarScan result{.start_ns = start, .beams = beams, .points = {}, .truth = {}};
  result.points.resize(static_cast<std::size_t>(beams));
  result.truth.resize(static_cast<std::size_t>(beams));
  constexpr int kRaysABlock = 64;  // ours: its arrays leave the caches to the meshes' hierarchies
  const std::int64_t block_size = std::max(1, kRaysABlock / rig.beam.rays());
  assert(block_size > 0);
  const std::int64_t blocks = (beams + block_size - 1) / block_size;
  std::vector<int> counts(static_cast<std::size_t>(blocks));
  for_each_block(blocks, threads, [&](std::int64_t block) {
    const std::int64_t from = block * block_size;
    const int count = static_cast<int>(std::min(block_size, beams - from));
    counts[static_cast<std::size_t>(block)] =
        cast_beams(casting, first, from, count, &result.points[static_cast<std::size_t>(from)],
                   &result.truth[static_cast<std::size_t>(from)]);
  });
  close_gaps(counts, block_size, result);
  return result;
}

}  // namespace uniquadric
