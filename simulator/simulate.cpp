#include "simulator/simulate.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <memory>
#include <string_view>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/hash.h"
#include "core/base/progress.h"
#include "core/base/source_hashes.h"
#include "core/base/text.h"
#include "core/base/threads.h"
#include "core/base/warning.h"
#include "simulator/frame_files.h"
#include "simulator/frame_log.h"
#include "simulator/imu/imu_files.h"
#include "simulator/lidar_files.h"
#include "simulator/map/occupancy_map.h"
#include "simulator/noise/exposure.h"
#include "simulator/render/renderer.h"
#include "simulator/scene/any_mesh.h"
#include "simulator/scene_files.h"
#include "simulator/stage_times.h"
#include "simulator/workers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// What a partial folder must have been made of to be gone on with.
std::string resume_key(const Scene& scene, const SimulateOptions& options, std::int64_t frames) {
  return Hash()
      .add(scene.hash)
      .add(options.seed)
      .add(static_cast<std::uint64_t>(options.gl))
      .add(static_cast<std::uint64_t>(frames))
      .add(kcore_sources)
      .add(ksimulator_sources)
      .hex();
}

// What shall draw. Says so before anything is written where there is no such library. OSMesa is loaded here,
// to be shared by the workers; EGL is tried in a process of its own, for they shall not inherit an open
// display.
GlLibrary checked_gl_library(GlLibrary asked) {
  const GlLibrary library = resolve_gl_library(asked);
  if (library == GlLibrary::osmesa)
    load_osmesa();
  else
    run_workers(
        1, [](int) { make_gl_context(GlLibrary::egl); }, [] {});
  return library;
}

// Empties a partial folder of another scene, seed, length or program; a scene without a hash cannot be told
// from another.
void discard_other_work(const Scene& scene, const std::string& key, const PendingFolder& pending) {
  const fs::path &folder = pending.path(), key_file = folder / "key";
  if (!scene.hash.empty() && fs::exists(key_file) && read_text(key_file) == key) return;
  pending.clear();
  create_frame_folders(scene, folder);
  write_text(key_file, key);
}

constexpr std::string_view kNoDepth = "no depth\n";  // in the frames' log, after a frame's visibility

// What a worker has to draw and write frames with, and what it does with one.
struct FrameMaker {
  const Scene& scene;
  std::uint64_t seed;
  Renderer renderer;
  FrameWriter writer;

  // Replaces the depth by that of an earlier time, where it comes late. What surfaces return of it belongs to
  // that time, too: drawing it takes some ms more, and is left out where all surfaces return all.
  void take_late_depth(double time_s, RenderedFrame& rendered) {
    if (scene.depth_noise.delay_s <= 0) return;
    const ScenePoses poses = poses_at(scene, time_s - scene.depth_noise.delay_s);
    if (!has_faint_surface(scene)) {
      rendered.depth_m = renderer.depth_m(poses);
      return;
    }
    const RenderedFrame& late = renderer.returned(poses);
    rendered.depth_m = late.depth_m;
    rendered.returning_rgba = late.rgba;
  }

  void make(std::int64_t frame, FrameLog& log, FrameTimes& times) {
    LapTimer timer(times);
    const double time_s =
        frame_time_s(scene, frame) - stamp_error_s(scene.imaging, scene.rate_hz, seed, frame);
    RenderedFrame rendered = renderer.render(poses_at(scene, time_s), color_steps(scene, time_s));
    take_late_depth(time_s, rendered);
    timer.lap(FrameStage::draw);
    const bool has_depth = writer.write(frame, rendered, timer);
    log.add(frame, visibility_lines(scene, frame, rendered) + std::string(has_depth ? "" : kNoDepth));
    times.count_frame();
  }
};

// What one worker does: takes frames until none is left. It renders and encodes its own frames with a
// renderer of its own: that keeps every core busy whichever of the two is slower, and holds one frame a
// worker in memory.
void write_frames_of(const Scene& scene, const SimulateOptions& options, const fs::path& folder,
                     SharedCounter& frames, FrameLog& log, FrameTimes& times) {
  std::unique_ptr<FrameMaker> maker;
  for (std::int64_t frame = frames.take(); frame < frames.limit(); frame = frames.take()) {
    if (!log.has(frame) && maker) {
      maker->make(frame, log, times);
    } else if (!log.has(frame)) {
      const StageClock clock;
      FrameTimes first;
      const std::uint64_t seed = scene.stream_seed(options.seed);
      maker.reset(new FrameMaker{scene, seed, Renderer(scene, options.gl), {scene, seed, folder}});
      maker->make(frame, log, first);
      times.add_first_frame(clock.seconds());
    }
    frames.finish();
  }
}

// Takes the log's notes out of its lines, which are left as visibility.csv has them.
std::int64_t take_empty_depths(std::string& lines) {
  std::int64_t count = 0;
  for (std::size_t at = 0; (at = lines.find(kNoDepth, at)) != lines.npos; ++count)
    lines.erase(at, kNoDepth.size());
  return count;
}

bool moves(const Motion& motion, const Scene& scene, std::int64_t frames) {
  constexpr double kLeast_m = 1e-6, kLeast_rad = 1e-6;  // ours: rounding is far below, a tremor above
  const Pose first = motion.at(frame_time_s(scene, 0));
  for (std::int64_t frame = 1; frame < frames; ++frame) {
    const Pose pose = motion.at(frame_time_s(scene, frame));
    if ((pose.translation - first.translation).norm() > kLeast_m ||
        pose.rotation.angularDistance(first.rotation) > kLeast_rad)
      return true;
  }
  return false;
}

// Of objects whose motion begins after the frames that are asked for.
void warn_of_rest(const Scene& scene, std::int64_t frames) {
  std::vector<std::string> names;
  for (const Body& body : scene.objects)
    if (frames < scene.frames && !moves(body.motion, scene, frames) &&
        moves(body.motion, scene, scene.frames))
      names.push_back(body.name);
  if (!names.empty())
    warn(fmt::format("scene {}: in the first {} of its {} frames these objects do not move yet: {}",
                     scene.name, frames, scene.frames, fmt::join(names, ", ")));
}

// Of objects of which one is in the box about another.
void warn_of_shared_places(const Scene& scene) {
  const auto is_in = [](const Body& inner, const Body& outer) {
    const Eigen::Vector3d middle = outer.motion.at(0).inverse() * inner.motion.at(0).translation;
    return (middle.cwiseAbs().array() < outer.semi_axes_m.array()).all();
  };
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    for (std::size_t k = 0; k < i; ++k) {
      const Body &a = scene.objects[k], &b = scene.objects[i];
      if (a.is_scored && b.is_scored && (is_in(a, b) || is_in(b, a)))
        warn(fmt::format("scene {}: objects {} and {} begin inside each other", scene.name, a.name, b.name));
    }
}

// Of objects that stand elsewhere than their author may have meant, by the lines of visibility.csv.
void warn_of_odd_views(const Scene& scene, const std::string& visibility) {
  constexpr double kFilled = 0.95;  // share of an image
  std::map<long long, long long> most_px;
  for (const std::string_view line : split(visibility, '\n')) {
    if (line.empty()) continue;
    const auto fields = split(line, ',');
    long long& most = most_px[*parse_integer(fields[2])];
    most = std::max(most, *parse_integer(fields[3]));
  }
  const double image_px = static_cast<double>(scene.camera.width) * scene.camera.height;
  for (const Body& body : scene.objects) {
    const auto px = static_cast<double>(most_px[body.id]);
    if (px == 0 && !scene.lidar && body.is_scored)
      warn(fmt::format("scene {}: object {} is in no image", scene.name, body.name));
    if (px > kFilled * image_px)
      warn(
          fmt::format("scene {}: object {} fills an image: is the camera inside it?", scene.name, body.name));
  }
}

// What needs no picture.
void write_descriptions(const Scene& scene, const SimulateOptions& options, std::int64_t frames,
                        const fs::path& folder, FrameTimes& times) {
  const StageClock clock;
  write_sequence_files(scene, options.seed, frames, folder / "sequence");
  write_truth_files(scene, frames, folder / "truth");
  write_imu_files(scene, scene.stream_seed(options.seed), frames, folder / "sequence", folder / "truth");
  times.add_descriptions(clock.seconds());
}

// The first worker writes what needs no picture before it takes its first frame.
void write_frames(const Scene& scene, const SimulateOptions& options, std::int64_t count,
                  const fs::path& folder, const fs::path& log_file, StageTimes& times) {
  const StageClock clock;
  const std::int64_t workers = std::min<std::int64_t>(threads_to_use(options.threads), count);
  SharedCounter frames(count);
  FrameTimes frame_times;
  FrameLog log(log_file);  // the workers append to it, a record a write
  Progress progress(fmt::format("simulate {}", scene.name), count, options.quiet);
  const std::int64_t missing = count - log.size();
  std::int64_t shown = 0;
  run_workers(
      static_cast<int>(workers),
      [&](int worker) {
        if (worker == 0) write_descriptions(scene, options, count, folder, frame_times);
        write_frames_of(scene, options, folder, frames, log, frame_times);
      },
      [&] {
        if (const std::int64_t steps = frames.finished() - shown; steps > 0)
          progress.advance(steps), shown += steps;
      });
  times.add("frames", clock.seconds(), missing);
  frame_times.add_to(times);
}

void hash_folders(const fs::path& folder, int threads, StageTimes& times) {
  const StageClock clock;
  for (const char* part : {"sequence", "truth"}) write_hashes(folder / part, threads);
  times.add("hashes", clock.seconds());
}

}  // namespace

void simulate(const Scene& scene, const SimulateOptions& asked, const fs::path& out) {
  SimulateOptions options = asked;
  check_can_render(scene);
  check_occupancy_map(scene.world, scene.map_resolution_m);
  const std::optional<LidarRig> lidar = lidar_of(scene);
  const std::int64_t frames = options.frames.value_or(scene.frames);
  if (frames < 1)
    throw InputError(fmt::format("scene {}: {} frames asked for, expected at least 1", scene.name, frames));
  if (!options.timing.empty() && !fs::is_directory(fs::absolute(options.timing).parent_path()))
    throw InputError(options.timing, "stands in a folder that does not exist");
  options.gl = checked_gl_library(asked.gl);
  PendingFolder pending(out, "simulation", options.force, true);
  const fs::path& folder = pending.path();
  discard_other_work(scene, resume_key(scene, options, frames), pending);
  const fs::path log_file = folder / "frames.log";
  StageTimes times;
  write_frames(scene, options, frames, folder, log_file, times);
  std::string visibility = FrameLog(log_file).lines();
  if (const std::int64_t empty = take_empty_depths(visibility); empty > 0)
    warn(fmt::format("scene {}: {} of {} depth images have no valid pixel", scene.name, empty, frames));
  write_visibility(folder, visibility);
  warn_of_odd_views(scene, visibility);
  warn_of_shared_places(scene);
  warn_of_rest(scene, frames);
  if (lidar) write_lidar_files(scene, *lidar, options, frames, folder, times);
  hash_folders(folder, options.threads, times);
  fs::remove(log_file);
  fs::remove(folder / "key");
  pending.commit();
  if (!options.timing.empty()) write_text(options.timing, times.csv());
}

}  // namespace uniquadric
