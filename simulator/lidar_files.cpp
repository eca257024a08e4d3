#include "simulator/lidar_files.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>

#include "core/base/progress.h"
#include "core/base/threads.h"
#include "simulator/lidar/lidar_reader.h"
#include "simulator/lidar/point_truth.h"
#include "simulator/octree_files.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kMaxImageField_deg = 150;  // a wider field spreads over a plane image too unevenly

// Without points' times where the scene says so.
LidarScan as_told(LidarScan scan, const LidarRig& rig) {
  if (!rig.point_times)
    for (LidarPoint& point : scan.points) point.offset_ns = 0;
  return scan;
}

void cast_scans(const Scene& scene, const LidarRig& rig, const SimulateOptions& options, std::size_t count,
                const fs::path& folder, StageTimes& times) {
  std::int64_t missing = 0;
  for (std::size_t k = 0; k < count; ++k) missing += !scan_files(folder, k).complete();
  const StageClock clock;
  const RayCaster caster(scene.world, scene.objects, rig.caster, rig.reflectivity);
  const PoseAt world_from_lidar = lidar_path(scene.camera_motion, rig);
  Progress progress(fmt::format("lidar {}", scene.name), static_cast<std::int64_t>(count), options.quiet);
  const std::uint64_t seed = scene.stream_seed(options.seed);
  tbb::task_arena arena(threads_to_use(options.threads));
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
      const auto number = static_cast<std::int64_t>(k);
      if (const ScanFiles files = scan_files(folder, k); !files.complete())
        write_scan(files, as_told(take_scan(caster, rig, world_from_lidar, number, seed), rig),
                   world_from_lidar(static_cast<double>(rig.start_ns(number)) * 1e-9));
      progress.advance();
    });
  });
  times.add("lidar", clock.seconds(), missing);
}

}  // namespace

bool ScanFiles::complete() const {
  return fs::exists(truth) && fs::exists(points);
}

ScanFiles scan_files(const fs::path& folder, std::size_t scan) {
  const std::string name = fmt::format("lidar/{:06}.pcd", scan);
  return {folder / "truth" / name, folder / "sequence" / name};
}

void write_scan(const ScanFiles& files, const LidarScan& scan, const Pose& world_from_lidar) {
  write_point_truth(files.truth, scan.truth, world_from_lidar);
  write_lidar_points(files.points, scan.points);
}

std::optional<LidarRig> lidar_of(const Scene& scene) {
  if (!scene.lidar) return std::nullopt;
  std::vector<fs::path> files;  // the scene's hash has them already
  LidarRig rig = read_lidar(*scene.lidar, files);
  scale_noise(rig.noise, scene.noise_scale);
  if (rig.method != LidarMethod::depth_octree) return rig;
  if (const FieldOfView field = field_of_view(rig.pattern);
      std::max(field.horizontal_deg, field.vertical_deg) > kMaxImageField_deg)
    scene.lidar->fail(fmt::format(
        "method depth_octree needs a field of view within {} deg, the pattern's is {:.0f} x {:.0f}",
        kMaxImageField_deg, field.horizontal_deg, field.vertical_deg));
  return rig;
}

std::vector<SequenceScan> lidar_scans(const Scene& scene, const LidarRig& rig, std::int64_t frames) {
  std::vector<SequenceScan> scans;
  for (std::int64_t k = 0; rig.start_ns(k + 1) <= scene.stamp_ns(frames - 1); ++k)
    scans.push_back({rig.start_ns(k), fmt::format("lidar/{:06}.pcd", k)});
  return scans;
}

void write_lidar_files(const Scene& scene, const LidarRig& rig, const SimulateOptions& options,
                       std::int64_t frames, const fs::path& folder, StageTimes& times) {
  for (const char* part : {"sequence", "truth"}) fs::create_directories(folder / part / "lidar");
  const std::size_t count = lidar_scans(scene, rig, frames).size();
  if (rig.method == LidarMethod::embree)
    cast_scans(scene, rig, options, count, folder, times);
  else
    write_octree_scans(scene, rig, options, count, folder, times);
}

}  // namespace uniquadric
