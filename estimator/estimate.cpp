#include "estimator/estimate.h"

#include <fmt/format.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <map>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/base/text.h"
#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "estimator/check_sequence.h"
#include "estimator/single_frame.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

std::map<std::int64_t, Pose> given_poses(const Sequence& sequence) {
  if (!sequence.given_camera || sequence.given_camera->empty())
    throw InputError(sequence.folder / "camera_given.tum",
                     "holds no camera poses, which the variant (ego: given) needs");
  std::map<std::int64_t, Pose> poses;
  for (const auto& [stamp_ns, pose] : *sequence.given_camera) poses.emplace(stamp_ns, pose);
  return poses;
}

std::vector<FrameEstimate> estimate_frames(const Sequence& sequence,
                                           const std::map<std::int64_t, Pose>& poses, const Variant& variant,
                                           const EstimateOptions& options, const fs::path& out) {
  const Segmenter segmenter = make_segmenter(sequence, variant.segmentation, options.prompts);
  check_sequence(sequence, segmenter, poses);
  const bool keeps_masks = segmenter.source != MaskSource::sequence;
  if (keeps_masks) fs::create_directories(out / "masks");
  Progress progress("estimate", std::ssize(sequence.frames), options.quiet);
  std::vector<FrameEstimate> results(sequence.frames.size());
  const int threads = options.threads > 0 ? options.threads : tbb::this_task_arena::max_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
  tbb::task_arena arena(threads);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, sequence.frames.size(), [&](std::size_t i) {
      const SequenceFrame& frame = sequence.frames[i];
      const auto pose = poses.find(frame.stamp_ns);
      results[i] =
          estimate_frame(sequence, frame, segmenter, variant,
                         pose == poses.end() ? std::nullopt : std::optional(pose->second), options.seed);
      if (keeps_masks && results[i].has_masks)
        write_png(out / "masks" / fmt::format("{:06}.png", frame.frame), results[i].masks);
      results[i].masks.release();
      progress.advance();
    });
  });
  return results;
}

Tracks collect(const Sequence& sequence, const std::map<std::int64_t, Pose>& poses, const Variant& variant,
               const std::vector<FrameEstimate>& frames) {
  Tracks tracks;
  for (const auto& frame : sequence.frames)
    if (const auto pose = poses.find(frame.stamp_ns); pose != poses.end())
      tracks.camera.push_back({frame.stamp_ns, pose->second});
  std::map<int, ObjectTrack> objects;
  for (const auto& frame : frames)
    for (const auto& [id, state] : frame.states) objects[id].states.push_back(state);
  for (auto& [id, track] : objects) {
    track.id = id;
    if (variant.axis_naming == AxisNaming::previous) follow_axes(track);
    tracks.objects.push_back(std::move(track));
  }
  return tracks;
}

std::string timing_csv(const std::vector<FrameEstimate>& frames) {
  std::string text = "frame,stage,ms\n";
  for (std::size_t i = 0; i < frames.size(); ++i)
    for (const auto& [stage, ms] : frames[i].timing_ms) text += fmt::format("{},{},{:.3f}\n", i, stage, ms);
  return text;
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
                     const std::vector<FrameEstimate>& frames) {
  const auto count = [&](auto is_counted) { return std::count_if(frames.begin(), frames.end(), is_counted); };
  int without_points = 0;
  for (const auto& frame : frames) without_points += frame.objects_without_state;
  std::string text = fmt::format("schema: 1\nprogram: {}\nsequence: {}\n", yaml_quoted(kProgram),
                                 yaml_quoted(sequence.name));
  if (!sequence.scene_hash.empty()) text += fmt::format("scene_hash: \"{}\"\n", sequence.scene_hash);
  const std::string prompts = options.prompts.empty() ? "everything" : options.prompts.filename().string();
  text += fmt::format("seed: {}\nprompts: {}\n", options.seed, yaml_quoted(prompts));
  text += fmt::format("frames: {}\n", frames.size());
  text += fmt::format("frames_with_states: {}\n", count([](const auto& f) { return !f.states.empty(); }));
  text += fmt::format("frames_without_pose: {}\n", count([](const auto& f) { return !f.has_pose; }));
  text += fmt::format("frames_without_depth: {}\n", count([](const auto& f) { return !f.has_depth; }));
  text += fmt::format("frames_without_masks: {}\n",
                      count([](const auto& f) { return f.has_depth && !f.has_masks; }));
  text += fmt::format("objects_with_too_few_points: {}\n", without_points);
  return text + "variant:\n" + indented(variant_yaml(variant));
}

}  // namespace

void estimate(const fs::path& sequence_folder, const Variant& variant, const EstimateOptions& options,
              const fs::path& out) {
  const Sequence sequence = open_sequence(sequence_folder);
  const auto poses = given_poses(sequence);
  PendingFolder pending(out, options.force);
  const auto frames = estimate_frames(sequence, poses, variant, options, pending.path());
  write_estimate(pending.path(), collect(sequence, poses, variant, frames));
  write_camera_yaml(pending.path() / "camera.yaml", sequence.camera);
  write_text(pending.path() / "timing.csv", timing_csv(frames));
  write_text(pending.path() / "run.yaml", run_yaml(sequence, variant, options, frames));
  pending.commit();
}

}  // namespace uniquadric
