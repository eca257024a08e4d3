#include "simulator/octree_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "simulator/lidar/depth_octree.h"
#include "simulator/lidar_files.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/pose_reader.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// ours: half the angle between neighbouring points of an Avia scan
constexpr int kImageWidth_px = 1024;
constexpr double kErrorCell_m = 0.01;  // ours: a tenth of the default octree cell
constexpr int kErrorCells = 101;       // to half a metre either way

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

std::string errors_csv(const std::vector<std::int64_t>& beams) {
  const auto edge = [](int cell) { return fmt::format("{:.3f}", (cell - kErrorCells / 2.0) * kErrorCell_m); };
  std::string text = "from_m,to_m,beams\n";
  for (int cell = 0; cell < kErrorCells; ++cell)
    text += fmt::format("{},{},{}\n", cell == 0 ? "" : edge(cell),
                        cell + 1 == kErrorCells ? "" : edge(cell + 1), beams[static_cast<std::size_t>(cell)]);
  return text;
}

// The depth image at a scan's start as an octree.
class OctreeCamera {
 public:
  OctreeCamera(Scene scene, const LidarRig& rig) : scene_(std::move(scene)), rig_(rig) {
    const FieldOfView field = field_of_view(rig.pattern);
    scene_.camera = camera_of_field(field.horizontal_deg, field.vertical_deg, kImageWidth_px);
    renderer_ = std::make_unique<Renderer>(scene_);
  }
  DepthOctree look(double time_s, const Pose& world_from_lidar) {
    const Pose lidar_from_camera = camera_from_body_axes().inverse();
    ScenePoses poses = poses_at(scene_, time_s);
    poses.world_from_camera = world_from_lidar * lidar_from_camera;
    return {renderer_->render(poses).depth_m, scene_.camera, lidar_from_camera, rig_.octree_resolution_m,
            rig_.noise.max_range_m};
  }

 private:
  Scene scene_;
  const LidarRig& rig_;
  std::unique_ptr<Renderer> renderer_;
};

}  // namespace

FieldOfView field_of_view(const ScanPattern& pattern) {
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

void write_octree_scans(Scene scene, const LidarRig& rig, const SimulateOptions& options, std::size_t count,
                        const fs::path& folder, StageTimes& times) {
  const PoseAt world_from_lidar = lidar_path(scene.camera_motion, rig);
  const RayCaster caster(scene.world, scene.objects, rig.caster, rig.reflectivity);
  const LidarRig reference_rig = exact(rig);
  Progress progress(fmt::format("lidar {}", scene.name), static_cast<std::int64_t>(count), options.quiet);
  OctreeCamera camera(std::move(scene), rig);
  std::string comparison = "scan,beams,matched,lost,extra,mean_m,median_abs_m,p95_abs_m,rms_m\n";
  std::vector<std::int64_t> errors(kErrorCells);
  for (std::size_t k = 0; k < count; ++k) {
    const auto number = static_cast<std::int64_t>(k);
    const double start_s = static_cast<double>(rig.start_ns(number)) * 1e-9;
    const StageClock octree_time;
    const LidarScan scan = take_octree_scan(camera.look(start_s, world_from_lidar(start_s)), rig, number);
    times.add("lidar_octree", octree_time.seconds());
    const StageClock embree_time;
    const LidarScan reference = take_scan(caster, reference_rig, world_from_lidar, number, options.seed, 1);
    times.add("lidar_embree", embree_time.seconds());
    write_scan(scan_files(folder, k), scan, world_from_lidar(start_s));
    const RangeComparison compared = compare_ranges(scan, reference, kErrorCell_m, kErrorCells);
    comparison += comparison_row(k, compared);
    for (std::size_t cell = 0; cell < errors.size(); ++cell) errors[cell] += compared.histogram[cell];
    progress.advance();
  }
  write_text(folder / "truth/lidar_comparison.csv", comparison);
  write_text(folder / "truth/lidar_errors.csv", errors_csv(errors));
}

}  // namespace uniquadric
