#include "estimator/estimate.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/hash.h"
#include "core/base/resource_usage.h"
#include "core/base/source_hashes.h"
#include "core/base/text.h"
#include "core/base/threads.h"
#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "estimator/backend.h"
#include "estimator/carve.h"
#include "estimator/estimate_warnings.h"
#include "estimator/factors/solver_log.h"
#include "estimator/single_frame.h"
#include "estimator/upright_backend.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

std::uint64_t seed_of_perception(const EstimateOptions& options) {
  return options.perception_seed.value_or(options.seed);
}

// Everything that the perception stage's result depends on.
std::string perception_key(const Sequence& sequence, const Variant& variant, const EstimateOptions& options) {
  Hash hash;
  hash.add(kProgram)
      .add(kcore_sources)
      .add(kestimator_sources)
      .add(perception_yaml(variant))
      .add(seed_of_perception(options));
  std::vector<fs::path> files;
  for (const char* name :
       {"sequence.yaml", "rgb.txt", "depth.txt", "masks.txt", "camera_given.tum", "lidar.txt", "imu.csv"})
    files.push_back(sequence.folder / name);
  const auto own = std::ssize(files);
  if (fs::is_directory(options.prompts.path)) {
    for (const auto& entry : fs::directory_iterator(options.prompts.path)) files.push_back(entry.path());
    std::sort(files.begin() + own, files.end());
  } else {
    files.push_back(options.prompts.path);
  }
  SegmentationOptions segmentation = variant.perception.segmentation;
  OptionWriter written;
  visit(written, segmentation);
  for (const std::string& network : written.texts()) files.emplace_back(network);
  for (const auto& network : {variant.perception.aot.nano.backbone, variant.perception.aot.nano.head})
    files.emplace_back(network);
  for (const SequenceFrame& frame : sequence.frames)
    for (const fs::path& image : {frame.rgb, frame.depth, frame.masks})
      if (!image.empty()) files.push_back(sequence.folder / image);
  for (const SequenceScan& scan : sequence.scans) files.push_back(sequence.folder / scan.file);
  for (const fs::path& file : files)
    if (fs::is_regular_file(file)) hash.add(file.filename().string()).add_file(file);
  return hash.hex();
}

// Which sequence it is, as long as its frames stay: images, masks and calibration may be edited.
std::string sequence_hash(const Sequence& sequence) {
  Hash hash;
  hash.add(sequence.name).add(sequence.scene_hash).add(sequence.seed);
  for (const SequenceFrame& frame : sequence.frames) hash.add(static_cast<std::uint64_t>(frame.stamp_ns));
  for (const SequenceScan& scan : sequence.scans) hash.add(static_cast<std::uint64_t>(scan.stamp_ns));
  return hash.hex();
}

// With its masks and times beside it, so that what is made of it does not depend on when it was made.
Perception perceive_into(const fs::path& folder, const Sequence& sequence, const Variant& variant,
                         const EstimateOptions& options, const std::string& key) {
  PerceiveOptions run;
  run.prompts = options.prompts;
  run.seed = seed_of_perception(options);
  run.threads = options.threads;
  run.quiet = options.quiet;
  run.masks_folder = folder / "masks";
  std::optional<JoinedBackend> joined;
  const Camera camera = perception_camera(sequence, variant.perception);
  if (variant.feedback == Feedback::backend)
    run.feedback = &joined.emplace(camera, variant.body, variant.joined, options.seed);
  fs::create_directories(folder);
  PerceptionWriter out(folder, camera, {key, sequence.name, sequence_hash(sequence)});
  std::vector<StageTime> times;
  perceive(sequence, variant.perception, run, out, times);
  write_text(folder / "timing.csv", timing_csv(times));
  return Perception(folder);
}

// What is replaced is deleted, which must be nobody else's.
void require_own_folder(const fs::path& folder) {
  if (!fs::is_directory(folder) || fs::is_empty(folder)) return;
  if (!fs::exists(folder / "perception.yaml"))
    throw InputError(folder, "is not empty and holds no perception; give another folder");
  if (const auto foreign = foreign_files(folder); !foreign.empty())
    throw InputError(
        folder / foreign.front(),
        "is no part of the kept perception that is to be replaced; move it, or give another folder");
}

// A cache of one sequence is renewed as options change; that of another is somebody's result.
void require_same_sequence(const fs::path& folder, const Sequence& sequence) {
  if (!fs::exists(folder / "perception.yaml")) return;
  const PerceptionSource source = perception_source_of(folder);
  if (source.sequence_hash == sequence_hash(sequence)) return;
  throw InputError(folder, source.sequence_hash.empty()
                               ? "holds a perception that does not say of which sequence it is; give another "
                                 "folder, or --force"
                               : fmt::format("holds the perception of another sequence ({}); give another "
                                             "folder, or --force",
                                             source.sequence));
}

void refuse_to_keep_joined(const Variant& variant, const EstimateOptions& options) {
  if (variant.feedback == Feedback::backend && !options.perception.empty())
    throw InputError(options.perception,
                     fmt::format("cannot keep the perception of {} (feedback: backend), which "
                                 "depends on its back end; leave out --perception",
                                 variant.name));
}

// What a kept perception may be replaced for.
enum class Replace {
  its_own,   // one of the same sequence that was made otherwise
  sequence,  // one of any sequence
  always,    // anything, even what would have done
};

Perception kept_perception(const Sequence& sequence, const Variant& variant, const EstimateOptions& options,
                           Replace replace) {
  const fs::path& folder = options.perception;
  const std::string key = perception_key(sequence, variant, options);
  const bool is_kept = fs::exists(folder / "perception.yaml") && perception_source_of(folder).key == key;
  if (replace == Replace::always || !is_kept) {
    if (replace != Replace::always) require_own_folder(folder);
    if (replace == Replace::its_own) require_same_sequence(folder, sequence);
    const UsageMeter meter;
    PendingFolder pending(folder, "perception", true);
    perceive_into(pending.path(), sequence, variant, options, key);
    write_usage(pending.path(), meter.used());
    pending.commit();
  }
  Perception perception(folder);
  if (camera_yaml(perception.camera()) != camera_yaml(perception_camera(sequence, variant.perception)))
    throw InputError(folder / "camera.yaml",
                     "is not the camera that this variant looks at the sequence with");
  return perception;
}

Variant of_camera_alone(Variant variant, const Sequence& sequence) {
  variant.feedback = Feedback::perception;  // there is no back end
  const bool has_masks = std::ranges::any_of(sequence.frames, [](const auto& f) { return !f.masks.empty(); });
  if (has_masks) return variant;
  variant.perception.segmentation.source = kNoMasks;
  variant.perception.aot.enabled = false;
  return variant;
}

BackendResult estimate_objects(const Perception& perception, const Variant& variant,
                               const EstimateOptions& options) {
  if (options.camera_only) {
    BackendResult nothing;
    nothing.fixed_lag.emplace();
    nothing.final.emplace();
    return nothing;
  }
  switch (variant.backend) {
    case Backend::single_frame:
      return estimate_single_frames(perception, variant, options.seed);
    case Backend::windows:
      return estimate_windows(perception, variant, options.seed);
    case Backend::upright:
      return estimate_upright(perception, variant);
  }
  throw std::logic_error("no such back end");
}

// What is known at one time: `pose_of` gives the camera's of a frame, or nothing.
template <typename PoseOf>
Tracks tracks_of(const Perception& perception, const std::vector<ObjectTrack>& objects,
                 const PoseOf& pose_of) {
  Tracks tracks;
  for (const FrameInfo& frame : perception.frames())
    if (const std::optional<Pose> pose = pose_of(frame)) tracks.camera.push_back({frame.stamp_ns, *pose});
  tracks.objects = objects;
  const std::map<std::int64_t, Pose> poses = by_stamp(tracks.camera);
  if (const auto& bias = perception.depth_bias())
    for (ObjectTrack& track : tracks.objects)
      for (ObjectState& state : track.states)
        if (const auto pose = poses.find(state.stamp_ns); pose != poses.end())
          add_bias_variance(*bias, pose->second, state);
  return tracks;
}

std::string indented(const std::string& yaml) {
  std::string text;
  for (std::size_t begin = 0; begin < yaml.size();) {
    const std::size_t end = yaml.find('\n', begin) + 1;
    text += "  " + yaml.substr(begin, end - begin);
    begin = end;
  }
  return text;
}

std::string run_yaml(const Sequence& sequence, const Variant& variant, const EstimateOptions& options,
                     const Perception& perception, const Tracks& tracks, int without_state) {
  std::set<std::int64_t> with_states;
  for (const ObjectTrack& track : tracks.objects)
    for (const ObjectState& state : track.states)
      if (state.status != ObjectStatus::lost) with_states.insert(state.frame);
  const auto count = [](const auto& list, auto is_counted) {
    return std::count_if(list.begin(), list.end(), is_counted);
  };
  std::string text = fmt::format("schema: 1\nprogram: {}\nsequence: {}\n", yaml_quoted(kProgram),
                                 yaml_quoted(sequence.name));
  if (!sequence.scene_hash.empty()) text += fmt::format("scene_hash: \"{}\"\n", sequence.scene_hash);
  const std::string prompts =
      options.prompts.empty() ? "everything" : options.prompts.path.filename().string();
  text += fmt::format("seed: {}\n", options.seed);
  if (options.perception_seed) text += fmt::format("perception_seed: {}\n", *options.perception_seed);
  text += fmt::format("prompts: {}\n", yaml_quoted(prompts));
  text += fmt::format("frames: {}\n", perception.frames().size());
  if (sequence.frames.empty()) text += "frames_are: scans\n";
  text += fmt::format("frames_with_states: {}\n", with_states.size());
  text += fmt::format("frames_without_pose: {}\n",
                      count(perception.frames(), [](const auto& f) { return !f.world_from_camera; }));
  text += fmt::format("ego_restarts: {}\n", perception.ego_restarts()) +
          depth_faults_yaml(perception.depth_bias(), perception.depth_edge_width_px());
  text += fmt::format("frames_without_depth: {}\n",
                      count(sequence.frames, [](const auto& f) { return f.depth.empty(); }) +
                          count(perception.frames(), [](const auto& f) { return f.depth_refused; }));
  text += fmt::format("frames_without_masks: {}\n",
                      count(perception.frames(), [](const auto& f) { return !f.has_masks; }));
  text += fmt::format("objects_without_state: {}\n", without_state);
  return text + "variant:\n" + indented(variant_yaml(variant));
}

// One of the trajectories of a run, in a folder of its own: `output` says when its states were known.
void write_output(const fs::path& folder, const Tracks& tracks, const std::map<int, SurfaceFile>& surfaces,
                  const Camera& camera, const std::string& output, const std::string& run) {
  fs::create_directories(folder);
  write_estimate(folder, tracks);
  for (const auto& [id, surface] : surfaces)
    write_surface_ply(folder / fmt::format("objects/{}.ply", id), surface,
                      "points seen, object frame, metres");
  write_camera_yaml(folder / "camera.yaml", camera);
  write_text(folder / "run.yaml", fmt::format("output: {}\n", output) + run);
}

void write_solids(const fs::path& folder, const std::map<int, SurfaceFile>& solids) {
  if (!solids.empty()) fs::create_directories(folder);
  for (const auto& [id, solid] : solids)
    write_surface_ply(folder / fmt::format("{}.ply", id), solid, "closed body, object frame, metres");
}

// What the frames show of the bodies' points, before any back end.
std::string features_csv(const Perception& perception) {
  std::string text = "frame,timestamp_ns,body,track,u_px,v_px,depth_m,depth_sigma_m\n";
  for (std::size_t i = 0; i < perception.frames().size(); ++i) {
    const PerceivedFrame frame = perception.read(i);
    for (const BodyObservation& body : frame.bodies)
      for (const Feature& f : body.features) {
        text += fmt::format("{},{},{},{},{:.3f},{:.3f},", frame.frame, frame.stamp_ns, body.id, f.track,
                            f.pixel.x(), f.pixel.y());
        text += f.depth_m > 0 ? fmt::format("{:.6g},{:.4g}\n", f.depth_m, f.depth_sigma_m) : ",\n";
      }
  }
  return text;
}

void copy_masks(const fs::path& from, const fs::path& to) {
  if (!fs::is_directory(from)) return;
  fs::create_directories(to);
  for (const auto& entry : fs::directory_iterator(from))
    duplicate_file(entry.path(), to / entry.path().filename());
}

}  // namespace

void estimate(const fs::path& sequence_folder, const Variant& wanted, const EstimateOptions& options,
              const fs::path& out) {
  keep_solver_silent();
  if (options.verify) require_unchanged_texts(sequence_folder);
  Sequence sequence = open_sequence(sequence_folder);
  const Variant variant = options.camera_only ? of_camera_alone(wanted, sequence) : wanted;
  refuse_to_keep_joined(variant, options);
  warn_of_the_calibration(sequence);
  warn_of_suspicions(sequence, variant, options);
  PendingFolder pending(out, "estimate", options.force);
  const auto threads = static_cast<std::size_t>(threads_to_use(options.threads));
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  const bool is_own = options.perception.empty();
  const UsageMeter own;
  const fs::path perceived = is_own ? pending.path() / "perception" : options.perception;
  const Perception perception =
      is_own
          ? perceive_into(perceived, sequence, variant, options, "")
          : kept_perception(sequence, variant, options, options.force ? Replace::sequence : Replace::its_own);
  if (const auto& bias = perception.depth_bias()) sequence.inverse_depth_bias_per_m = bias->per_m;
  sequence.depth_edge_width_px = perception.depth_edge_width_px();
  // from here on, and before it what the perception took, whoever made it and when
  const ResourceUsage before = is_own ? own.used() : read_usage(perceived).value_or(ResourceUsage{});
  const UsageMeter backend;
  BackendResult result = estimate_objects(perception, variant, options);
  const std::int64_t last_frame = perception.frames().empty() ? 0 : perception.frames().back().frame;
  Stopwatch watch(last_frame, result.times);
  const std::map<int, SurfaceFile> solids = carve_bodies(sequence, perception, result, variant);
  watch.stop("carve");
  const Tracks causal = tracks_of(perception, result.causal, [](const FrameInfo& frame) {
    return frame.camera_came_late ? std::nullopt : frame.world_from_camera;
  });
  if (fs::exists(perceived / kMapFile)) duplicate_file(perceived / kMapFile, pending.path() / kMapFile);
  copy_masks(perceived / "masks", pending.path() / "masks");
  const std::string run =
      run_yaml(sequence, variant, options, perception, causal, result.observations_without_state);
  write_output(pending.path(), causal, result.surfaces, sequence.camera, "causal", run);
  if (result.fixed_lag)
    write_output(pending.path() / "fixed_lag",
                 tracks_of(perception, *result.fixed_lag, [](const auto& f) { return f.lagged_camera; }),
                 result.surfaces, sequence.camera, "fixed_lag", run);
  if (result.final) {
    write_output(pending.path() / "final",
                 tracks_of(perception, *result.final, [](const auto& f) { return f.final_camera; }),
                 result.surfaces, sequence.camera, "final", run);
    write_solids(pending.path() / "final/solids", solids);
  }
  if (variant.write_features) write_text(pending.path() / "features.csv", features_csv(perception));
  write_text(pending.path() / "timing.csv", timing_csv(result.times, read_text(perceived / "timing.csv")));
  if (is_own) fs::remove_all(perceived);
  write_usage(pending.path(), before + backend.used());
  pending.commit();
  warn_of_little(perception, causal, !sequence.frames.empty(), !options.camera_only);
}

void keep_perception(const fs::path& sequence_folder, const Variant& variant,
                     const EstimateOptions& options) {
  keep_solver_silent();
  refuse_to_keep_joined(variant, options);
  if (options.verify) require_unchanged_texts(sequence_folder);
  const Sequence sequence = open_sequence(sequence_folder);
  warn_of_the_calibration(sequence);
  warn_of_suspicions(sequence, variant, options);
  kept_perception(sequence, variant, options, options.force ? Replace::always : Replace::its_own);
}

}  // namespace uniquadric
