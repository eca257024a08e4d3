#include "harness/info.h"
#include "harness/perception_info.h"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/sequence/calibration.h"
#include "core/sequence/estimated_objects.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "estimator/variant.h"
#include "evaluation/report/report.h"
#include "harness/bench/plan.h"
#include "simulator/lidar_files.h"
#include "simulator/scene/scene.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

double seconds(std::int64_t ns) {
  return static_cast<double>(ns) * 1e-9;
}

double path_length_m(const Trajectory& trajectory) {
  double length = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length += (trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm();
  return length;
}

// From the first to the last; 0 of none.
template <typename Stamped>
double span_s(const std::vector<Stamped>& list) {
  return list.empty() ? 0 : seconds(list.back().stamp_ns - list.front().stamp_ns);
}

std::string describe_trajectory(const Trajectory& trajectory) {
  if (trajectory.empty()) return "0 poses";
  return fmt::format("{} poses over {:.3f} s, path {:.3f} m", trajectory.size(), span_s(trajectory),
                     path_length_m(trajectory));
}

std::string describe_sequence(const fs::path& path) {
  const Sequence sequence = open_sequence(path);
  const auto& frames = sequence.frames;
  const auto count = [&](auto has) { return std::count_if(frames.begin(), frames.end(), has); };
  const Camera& camera = sequence.camera;
  std::string text = fmt::format("sequence '{}' made by {}", sequence.name, sequence.program);
  if (!sequence.scene_hash.empty())
    text += fmt::format(", scene {}, seed {}", sequence.scene_hash, sequence.seed);
  if (!sequence.realism.empty()) text += ", realism " + sequence.realism;
  text += fmt::format("\ncamera: {}x{} px, fx {} fy {} cx {} cy {}, {} Hz{}\n", camera.width, camera.height,
                      camera.fx, camera.fy, camera.cx, camera.cy, sequence.rate_hz,
                      camera.has_distortion() ? ", distorted" : "");
  text += fmt::format("frames: {} over {:.3f} s; {} with depth, {} with masks\n", frames.size(),
                      span_s(frames), count([](const SequenceFrame& f) { return !f.depth.empty(); }),
                      count([](const SequenceFrame& f) { return !f.masks.empty(); }));
  if (const auto& lidar = sequence.lidar)
    text += fmt::format("lidar: {}, {} Hz; {} scans over {:.3f} s\n", lidar->pattern, lidar->rate_hz,
                        sequence.scans.size(), span_s(sequence.scans));
  if (sequence.imu) text += fmt::format("imu: {} Hz\n", sequence.imu->rate_hz);
  text += "camera poses given: " +
          (sequence.given_camera ? describe_trajectory(*sequence.given_camera) : "none") + "\n";
  return text;
}

// Ids of a truth's objects of which evaluation has no figures; of an estimate none.
std::set<int> unscored_of(const fs::path& folder) {
  std::set<int> ids;
  const fs::path objects = folder / "objects.yaml";
  if (fs::exists(folder / "objects.csv") || !fs::exists(objects) || is_size_list(objects)) return ids;
  for (const ObjectDescription& object : read_objects_yaml(objects))
    if (!object.is_scored) ids.insert(object.id);
  return ids;
}

std::string describe_tracks(const fs::path& path) {
  const Tracks tracks = read_tracks(path);
  const std::set<int> unscored = unscored_of(path);
  std::string text = fs::exists(path / "objects.csv") ? "estimate\n" : "truth\n";
  text += "camera: " + describe_trajectory(tracks.camera) + "\n";
  for (const auto& track : tracks.objects) {
    const auto lost = std::count_if(track.states.begin(), track.states.end(), [](const ObjectState& state) {
      return state.status == ObjectStatus::lost;
    });
    text += fmt::format("object {}{}: {} states", track.id, track.name.empty() ? "" : " '" + track.name + "'",
                        std::ssize(track.states) - lost);
    if (unscored.contains(track.id)) text += ", not scored";
    if (lost > 0) text += fmt::format(", lost {} times", lost);
    if (!track.states.empty()) {
      const auto& a = track.states.back().ellipsoid.semi_axes_m;
      text += fmt::format(", last semi-axes {:.4f} {:.4f} {:.4f} m", a.x(), a.y(), a.z());
      const auto in_motion = [&](ObjectMotion motion) {
        return std::count_if(track.states.begin(), track.states.end(),
                             [&](const ObjectState& state) { return state.motion == motion; });
      };
      const auto at_rest = in_motion(ObjectMotion::at_rest), moving = in_motion(ObjectMotion::moving);
      if (at_rest + moving > 0) text += fmt::format(", static in {}, dynamic in {}", at_rest, moving);
    }
    text += "\n";
  }
  return text;
}

std::string describe_scene(const fs::path& path) {
  const Scene scene = load_scene(path);
  std::string text = fmt::format("scene '{}' ({}): {} frames at {} Hz, {}x{} px{}\n", scene.name, scene.hash,
                                 scene.frames, scene.rate_hz, scene.camera.width, scene.camera.height,
                                 scene.realism.empty() ? "" : ", realism " + scene.realism);
  if (const auto lidar = lidar_of(scene))
    text += fmt::format("lidar: {}, {} Hz\n", lidar->pattern_name, lidar->rate_hz);
  if (scene.imu) text += fmt::format("imu: {} Hz\n", scene.imu->calibration.rate_hz);
  for (const Body& body : scene.objects) {
    std::size_t triangles = 0;
    for (const Mesh& mesh : body.meshes) triangles += mesh.triangles.size();
    const auto& a = body.semi_axes_m;
    text += fmt::format("object {} '{}': {}, semi-axes {:.4f} {:.4f} {:.4f} m, {} triangles{}\n", body.id,
                        body.name, body.shape, a.x(), a.y(), a.z(), triangles,
                        body.is_scored ? "" : ", not scored");
  }
  return text;
}

std::string describe_yaml(const fs::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  if (!root.is_map()) throw InputError(path, "is no scene, variant or bench file");
  if (root.has("scenes")) {
    const BenchConfig config = load_bench_config(path);
    check_variants(config);
    return fmt::format("bench '{}': {} scenes x {} variants x {} seeds\n", config.name, config.scenes.size(),
                       config.variants.size(), config.seeds.size());
  }
  if (root.has("camera")) return describe_scene(path);
  return "variant\n" + variant_yaml(load_variant(path));
}

std::string describe_folder(const fs::path& path) {
  if (fs::exists(path / "sequence.yaml")) return describe_sequence(path);
  if (fs::exists(path / "sequence/sequence.yaml"))
    return describe_sequence(path / "sequence") +
           (fs::exists(path / "truth") ? describe_tracks(path / "truth") : "");
  if (is_perception(path)) return describe_perception(path);
  if (fs::exists(path / "camera.tum")) return describe_tracks(path);
  if (fs::exists(path / "cells.csv")) return "results\n" + summary_table(path);
  if (fs::exists(path / "evaluation.json"))
    return "evaluation: see " + (path / "evaluation.json").string() + "\n";
  throw InputError(path, "is no sequence, truth, perception, estimate, evaluation or results folder");
}

}  // namespace

std::string describe(const fs::path& path) {
  if (fs::is_directory(path)) return describe_folder(path);
  if (!fs::exists(path)) throw InputError(path, "does not exist");
  if (path.extension() == ".tum") return "trajectory: " + describe_trajectory(read_tum(path)) + "\n";
  if (path.extension() == ".yaml") return describe_yaml(path);
  throw InputError(path, "is of no kind this program knows (.yaml, .tum, folders)");
}

}  // namespace uniquadric
