#include "simulator/scene_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "core/sequence/ply.h"
#include "core/sequence/sequence.h"
#include "core/sequence/trajectory.h"
#include "simulator/frame_files.h"
#include "simulator/lidar_files.h"
#include "simulator/map/occupancy_map.h"
#include "simulator/noise/segmenter.h"
#include "simulator/scene/mesh_building.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Trajectory sample(const Scene& scene, const Motion& motion, std::int64_t frames) {
  Trajectory trajectory;
  for (std::int64_t frame = 0; frame < frames; ++frame)
    trajectory.push_back({scene.stamp_ns(frame), motion.at(frame_time_s(scene, frame))});
  return trajectory;
}

// All materials' triangles in one mesh, without normals: what a surface is compared with.
SurfaceFile surface_of(const Body& body) {
  Mesh whole;
  for (const Mesh& mesh : body.meshes) merge(whole, mesh);
  return {std::move(whole.positions), {}, std::move(whole.triangles)};
}

SequenceFrame list_frame(const Scene& scene, std::uint64_t seed, std::int64_t frame) {
  const std::string file = fmt::format("{:06}.png", frame);
  SequenceFrame listed;
  listed.frame = frame;
  listed.stamp_ns = scene.stamp_ns(frame);
  listed.rgb = fs::path("rgb") / file;
  if (scene.depth) listed.depth = fs::path("depth") / file;
  if (is_segmented(scene.segmenter, seed, frame, scene.rate_hz)) {
    listed.masks = fs::path("masks") / file;
    listed.masks_arrival_ns = listed.stamp_ns + std::llround(latency_s(scene.segmenter, seed, frame) * 1e9);
  }
  return listed;
}

// A segmenter gives its results in the order of the frames: who is slow holds up those behind.
std::vector<SequenceFrame> list_frames(const Scene& scene, std::uint64_t seed, std::int64_t frames) {
  std::vector<SequenceFrame> listed;
  std::int64_t last_ns = std::numeric_limits<std::int64_t>::min();
  for (std::int64_t frame = 0; frame < frames; ++frame) {
    listed.push_back(list_frame(scene, seed, frame));
    if (listed.back().masks.empty()) continue;
    last_ns = listed.back().masks_arrival_ns = std::max(last_ns, listed.back().masks_arrival_ns);
  }
  return listed;
}

}  // namespace

double frame_time_s(const Scene& scene, std::int64_t frame) {
  return static_cast<double>(scene.stamp_ns(frame)) / 1e9;
}

void write_sequence_files(const Scene& scene, std::uint64_t seed, std::int64_t frames,
                          const fs::path& folder) {
  Sequence sequence;
  sequence.program = kProgram;
  sequence.name = scene.name;
  sequence.scene_hash = scene.hash;
  sequence.seed = seed;
  sequence.realism = scene.realism;
  sequence.camera = scene.told_camera();
  sequence.rate_hz = scene.rate_hz;
  sequence.rolling_shutter_s = scene.imaging.rolling_shutter_s;
  sequence.depth_units_per_m = depth_units_per_m(scene.depth_noise);
  sequence.frames = list_frames(scene, scene.stream_seed(seed), frames);
  if (scene.imu) sequence.imu = scene.imu->calibration;
  if (scene.imu) sequence.imu->camera_from_imu = sequence.imu->camera_from_imu * scene.imu->mounting_error;
  if (const auto rig = lidar_of(scene)) {
    sequence.lidar = LidarCalibration{rig->pattern_name, rig->rate_hz,
                                      rig->camera_from_lidar * rig->mounting_error, rig->data_sheet};
    sequence.scans = lidar_scans(scene, *rig, frames);
    for (SequenceScan& scan : sequence.scans) scan.stamp_ns += std::llround(rig->time_offset_s * 1e9);
  }
  if (scene.given_camera) sequence.given_camera = sample(scene, scene.camera_motion, frames);
  write_sequence_index(folder, sequence);
}

void write_truth_files(const Scene& scene, std::int64_t frames, const fs::path& folder) {
  fs::create_directories(folder / "objects");
  write_tum(folder / "camera.tum", sample(scene, scene.camera_motion, frames));
  write_camera_yaml(folder / "camera.yaml", scene.camera);
  std::vector<ObjectDescription> descriptions;
  for (const Body& body : scene.objects) {
    write_tum(folder / "objects" / fmt::format("{}.tum", body.id), sample(scene, body.motion, frames));
    write_surface_ply(folder / "objects" / fmt::format("{}.ply", body.id), surface_of(body),
                      "mesh, object frame, metres");
    descriptions.push_back(
        {body.id, body.name, body.semi_axes_m, body.shape, body.mesh_file, body.symmetry, body.is_scored});
  }
  write_objects_yaml(folder / "objects.yaml", descriptions, scene.hash);
  write_occupancy_map(folder / "map.bt", scene.world, scene.map_resolution_m);
}

}  // namespace uniquadric
