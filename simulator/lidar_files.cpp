#include "simulator/lidar_files.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/progress.h"
#include "simulator/lidar/depth_octree.h"
#include "simulator/lidar/lidar_reader.h"
#include "simulator/lidar/point_truth.h"
#include "simulator/render/renderer.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kOctreeImageWidth_px =
    1024;  // ours: half the angle between neighbouring points of an Avia scan
constexpr double kMaxImageField_deg = 150;  // a wider field spreads over a plane image too unevenly

// Files of one scan, the points last: they say that it is complete.
struct ScanFiles {
  fs::path truth, points;
  bool complete() const { return fs::exists(truth) && fs::exists(points); }
};

ScanFiles files_of(const fs::path& folder, std::size_t scan) {
  const std::string name = fmt::format("lidar/{:06}.pcd", scan);
  return {folder / "truth" / name, folder / "sequence" / name};
}

void write_scan(const ScanFiles& files, const LidarScan& scan, const Pose& world_from_lidar) {
  write_point_truth(files.truth, scan.truth, world_from_lidar);
  write_lidar_points(files.points, scan.points);
}

void cast_scans(const Scene& scene, const LidarRig& rig, const SimulateOptions& options, std::size_t count,
                const fs::path& folder) {
  const RayCaster caster(scene.world, scene.objects, rig.caster, rig.reflectivity);
  const PoseAt world_from_lidar = lidar_path(scene.camera_motion, rig);
  Progress progress(fmt::format("lidar {}", scene.name), static_cast<std::int64_t>(count), options.quiet);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, count, [&](std::size_t k) {
      const auto number = static_cast<std::int64_t>(k);
      if (const ScanFiles files = files_of(folder, k); !files.complete())
        write_scan(files, take_scan(caster, rig, world_from_lidar, number, options.seed),
                   world_from_lidar(static_cast<double>(rig.start_ns(number)) * 1e-9));
      progress.advance();
    });
  });
}

// Full angles in which a second of beams lies, both sides of x alike.
std::pair<double, double> field_of_view_deg(const ScanPattern& pattern) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  constexpr double kFullAngle = 2 * 180 / std::numbers::pi;  // deg a radian of half the field
  double horizontal = 0, vertical = 0;
  BeamBlock block;
  const std::int64_t end = pattern.first_at(kSecond_ns);
  for (std::int64_t first = 0; first < end; first += block.count) {
    pattern.fill(first, static_cast<int>(std::min<std::int64_t>(BeamBlock::kCapacity, end - first)), block);
    for (int i = 0; i < block.count; ++i) {
      horizontal = std::max(horizontal, std::atan2(std::abs(block.y[i]), block.x[i]));
      vertical = std::max(vertical, std::atan2(std::abs(block.z[i]), block.x[i]));
    }
  }
  return {kFullAngle * horizontal, kFullAngle * vertical};
}

// The rig with which Embree shows what the octree loses: the same beams without any error.
LidarRig exact(LidarRig rig) {
  rig.method = LidarMethod::embree;
  rig.noise = LidarNoise::none();
  rig.beam.vertical_rays = rig.beam.horizontal_rays = 1;
  return rig;
}

std::string comparison_row(std::size_t scan, const RangeComparison& c) {
  return fmt::format("{},{},{},{},{},{},{},{},{}\n", scan, c.beams, c.matched, c.lost, c.extra, c.mean_m,
                     c.median_abs_m, c.p95_abs_m, c.rms_m);
}

// The paper's route: one depth image at each scan's start stands for the whole scan.
void octree_scans(Scene scene, const LidarRig& rig, const SimulateOptions& options, std::size_t count,
                  const fs::path& folder) {
  const auto [horizontal_deg, vertical_deg] = field_of_view_deg(rig.pattern);
  const PoseAt world_from_lidar = lidar_path(scene.camera_motion, rig);
  const Pose lidar_from_camera = camera_from_body().inverse();
  const RayCaster caster(scene.world, scene.objects, rig.caster, rig.reflectivity);
  const LidarRig reference = exact(rig);
  scene.camera = camera_of_field(horizontal_deg, vertical_deg, kOctreeImageWidth_px);
  Renderer renderer(scene);
  Progress progress(fmt::format("lidar {}", scene.name), static_cast<std::int64_t>(count), options.quiet);
  std::string comparison = "scan,beams,matched,lost,extra,mean_m,median_abs_m,p95_abs_m,rms_m\n";
  for (std::size_t k = 0; k < count; ++k) {
    const auto number = static_cast<std::int64_t>(k);
    const double start_s = static_cast<double>(rig.start_ns(number)) * 1e-9;
    ScenePoses poses = poses_at(scene, start_s);
    poses.world_from_camera = world_from_lidar(start_s) * lidar_from_camera;
    const DepthOctree octree(renderer.render(poses).depth_m, scene.camera, lidar_from_camera,
                             rig.octree_resolution_m, rig.noise.max_range_m);
    const LidarScan scan = take_octree_scan(octree, rig, number);
    write_scan(files_of(folder, k), scan, world_from_lidar(start_s));
    comparison += comparison_row(k, compare_ranges(scan, take_scan(caster, reference, world_from_lidar,
                                                                   number, options.seed, options.threads)));
    progress.advance();
  }
  write_text(folder / "truth/lidar_comparison.csv", comparison);
}

}  // namespace

std::optional<LidarRig> lidar_of(const Scene& scene) {
  if (!scene.lidar) return std::nullopt;
  std::vector<fs::path> files;  // the scene's hash has them already
  const LidarRig rig = read_lidar(*scene.lidar, files);
  const auto [horizontal_deg, vertical_deg] = field_of_view_deg(rig.pattern);
  if (rig.method == LidarMethod::depth_octree && std::max(horizontal_deg, vertical_deg) > kMaxImageField_deg)
    scene.lidar->fail(fmt::format(
        "method depth_octree needs a field of view within {} deg, the pattern's is {:.0f} x {:.0f}",
        kMaxImageField_deg, horizontal_deg, vertical_deg));
  return rig;
}

std::vector<SequenceScan> lidar_scans(const Scene& scene, const LidarRig& rig, std::int64_t frames) {
  std::vector<SequenceScan> scans;
  for (std::int64_t k = 0; rig.start_ns(k + 1) <= scene.stamp_ns(frames - 1); ++k)
    scans.push_back({rig.start_ns(k), fmt::format("lidar/{:06}.pcd", k)});
  return scans;
}

void write_lidar_files(const Scene& scene, const LidarRig& rig, const SimulateOptions& options,
                       std::int64_t frames, const fs::path& folder) {
  for (const char* part : {"sequence", "truth"}) fs::create_directories(folder / part / "lidar");
  const std::size_t count = lidar_scans(scene, rig, frames).size();
  if (rig.method == LidarMethod::embree)
    cast_scans(scene, rig, options, count, folder);
  else
    octree_scans(scene, rig, options, count, folder);
}

}  // namespace uniquadric
