#include "evaluation/evaluate.h"

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <tuple>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/warning.h"
#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "evaluation/association/hidden_objects.h"
#include "evaluation/association/object_overlap.h"
#include "evaluation/evaluation_files.h"
#include "evaluation/false_bodies.h"
#include "evaluation/image_overlap.h"
#include "evaluation/object_presence.h"
#include "evaluation/object_solid.h"
#include "evaluation/object_surface.h"
#include "evaluation/run_record.h"
#include "evaluation/stamp_check.h"
#include "evaluation/unit_check.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kMaxDifferenceNs = 10'000'000;  // SPEC 6: |dt| <= 0.01 s, evo's default
constexpr double kAnyOverlap = 0;  // an id counts as switched however little the tracks overlap

// What the truth says of its objects, by id; empty where the folder does not say (an estimate taken as
// truth).
std::map<int, ObjectDescription> read_descriptions(const fs::path& truth) {
  std::map<int, ObjectDescription> descriptions;
  if (fs::exists(truth / "objects.yaml"))
    for (const ObjectDescription& object : read_objects_yaml(truth / "objects.yaml"))
      descriptions[object.id] = object;
  return descriptions;
}

// A recording without a truth: its camera's poses, where another system knows them, and no objects.
Tracks truth_of_sequence(const fs::path& folder) {
  const Sequence sequence = open_sequence(folder);
  return {sequence.given_camera.value_or(Trajectory{}), {}, sequence.camera};
}

// camera_from_object in the place of world_from_object; states of frames without a camera pose are left out.
Tracks in_sensor_frame(const Tracks& tracks) {
  Tracks seen = tracks;
  for (ObjectTrack& object : seen.objects) {
    std::erase_if(object.states, [&](const ObjectState& state) {
      return !nearest_pose(tracks.camera, state.stamp_ns, kMaxDifferenceNs);
    });
    for (ObjectState& state : object.states) {
      Pose& pose = state.ellipsoid.world_from_object;
      pose = nearest_pose(tracks.camera, state.stamp_ns, kMaxDifferenceNs)->inverse() * pose;
    }
  }
  for (StampedPose& pose : seen.camera) pose.pose = {};
  return seen;
}

// All that is compared with, read once for all outputs of an estimate.
struct Truth {
  fs::path folder;
  std::string scene;
  bool knows_objects = true;
  TruthNotes notes;
  Tracks tracks;
  VisibilityTable visibility;
  std::map<int, ObjectDescription> descriptions;
  BallSamples samples;
  std::map<int, std::unique_ptr<const TrueSolid>> bodies{};  // made when they are asked for; null: not known

  const TrueSolid* body(int id, std::uint64_t seed) {
    const auto described = descriptions.find(id);
    if (described == descriptions.end()) return nullptr;
    const auto [known, is_new] = bodies.try_emplace(id);
    if (is_new) known->second = true_solid(folder, described->second, seed);
    return known->second.get();
  }
  bool is_scored(const ObjectTrack& object) const {
    const auto described = descriptions.find(object.id);
    return described == descriptions.end() || described->second.is_scored;
  }
};

// Which track belongs to which object, and what of both is judged.
struct Association {
  ObjectOverlaps overlaps;
  std::vector<std::optional<std::size_t>> matches;  // the track of each object
  std::vector<bool> scored;                         // [object]
  std::vector<bool> left_out;  // [track]: it belongs to an object that is not to be scored
};

Association associate_objects(const Truth& reference, const Tracks& estimate, const ObjectChoice& choice) {
  const std::vector<ObjectTrack>& objects = reference.tracks.objects;
  Association result{overlap_objects(reference.tracks, estimate, kMaxDifferenceNs), {}, {}, {}};
  result.matches = match_objects(result.overlaps);
  result.scored = scored_objects(objects, choice);
  std::vector<bool> unscored;
  for (const ObjectTrack& object : objects) unscored.push_back(!reference.is_scored(object));
  result.left_out = tracks_of(unscored, result.matches, result.overlaps);
  for (std::size_t g = 0; g < objects.size(); ++g) result.scored[g] = result.scored[g] && !unscored[g];
  return result;
}

// The tracks that are matched to no object and left out for none.
std::vector<int> unmatched_tracks(const Association& association, const Tracks& estimate) {
  std::vector<bool> used = association.left_out;
  for (const auto& track : association.matches)
    if (track) used[*track] = true;
  std::vector<int> ids;
  for (std::size_t e = 0; e < used.size(); ++e)
    if (!used[e]) ids.push_back(estimate.objects[e].id);
  return ids;
}

// What an estimate says of sizes needs no truth; tracks that a truth leaves out are left out here too.
std::vector<SizeSteadiness> judged_sizes(const Association& association, const Tracks& estimate) {
  std::vector<ObjectTrack> judged;
  for (std::size_t e = 0; e < estimate.objects.size(); ++e)
    if (!association.left_out[e]) judged.push_back(estimate.objects[e]);
  return size_steadiness(judged);
}

// For each truth state the track's state in the same frame.
std::vector<std::optional<MatchedState>> states_of_match(const ObjectOverlaps& overlaps, std::size_t object,
                                                         std::size_t states,
                                                         std::optional<std::size_t> track) {
  std::vector<std::optional<MatchedState>> matched(states);
  for (std::size_t frame = 0; track && frame < overlaps.stamps_ns.size(); ++frame)
    if (const auto state = overlaps.truth[object][frame], same = overlaps.estimate[*track][frame];
        state && same)
      matched[*state] = {*same, overlaps.iou3d[object][*track][frame]};
  return matched;
}

VisibilityTable read_visibility_of(const fs::path& folder, const Tracks& truth) {
  const fs::path file = folder / "instances/visibility.csv";
  if (!fs::exists(file)) return {};
  VisibilityTable table = read_visibility(file);
  std::size_t states = 0, without = 0;
  for (const ObjectTrack& object : truth.objects)
    for (const ObjectState& state : object.states) {
      ++states;
      without += table.contains({state.frame, object.id}) ? 0 : 1;
    }
  if (without > 0)
    warn(fmt::format("{}: has no row of {} of {} true states, which count as visible", file.string(), without,
                     states));
  return table;
}

// [object][frame]: whether the truth says that the object cannot be seen there.
std::vector<std::vector<bool>> hidden_frames(const Tracks& truth, const ObjectOverlaps& overlaps,
                                             const VisibilityTable& visibility) {
  std::vector<std::vector<bool>> hidden(truth.objects.size(), std::vector<bool>(overlaps.stamps_ns.size()));
  for (std::size_t g = 0; g < hidden.size(); ++g)
    for (std::size_t frame = 0; frame < hidden[g].size(); ++frame) {
      if (!overlaps.truth[g][frame]) continue;
      const ObjectTrack& object = truth.objects[g];
      const auto seen = visibility.find({object.states[*overlaps.truth[g][frame]].frame, object.id});
      hidden[g][frame] = seen != visibility.end() && !is_visible(seen->second);
    }
  return hidden;
}

// What counts in the scores over all objects.
ObjectOverlaps counted_overlaps(const Truth& reference, const Association& association,
                                Unlabelled unlabelled) {
  const auto& [overlaps, matches, scored, left_out] = association;
  ObjectOverlaps counted = overlaps;
  auto hidden = hidden_frames(reference.tracks, overlaps, reference.visibility);
  for (std::size_t g = 0; g < hidden.size(); ++g)
    if (!scored[g]) hidden[g].assign(hidden[g].size(), true);
  drop_unlabelled(unlabelled, reference.notes.is_partial, matches, counted);
  drop_hidden(hidden, matches, left_out, counted);
  return counted;
}

Truth read_truth(const fs::path& folder, const std::string& scene, const EvaluateOptions& options) {
  const bool knows_objects = !fs::exists(folder / "sequence.yaml");
  const TruthNotes notes =
      fs::exists(folder / "objects.yaml") ? read_truth_notes(folder / "objects.yaml") : TruthNotes{};
  Tracks tracks = knows_objects ? read_tracks(folder) : truth_of_sequence(folder);
  VisibilityTable visibility = read_visibility_of(folder, tracks);
  if (options.objects.in_view) tracks.objects = only_in_view(std::move(tracks.objects), visibility);
  return {folder,
          scene,
          knows_objects,
          notes,
          std::move(tracks),
          std::move(visibility),
          read_descriptions(folder),
          BallSamples(options.iou_samples, options.seed)};
}

Evaluation compare(const Truth& reference, const Tracks& estimate, const EvaluateOptions& options) {
  const auto& [truth, visibility, descriptions] =
      std::tie(reference.tracks, reference.visibility, reference.descriptions);
  const Unlabelled unlabelled = options.unlabelled.value_or(
      reference.notes.is_partial ? Unlabelled::ignored : Unlabelled::counted_false);
  Evaluation result;
  result.unlabelled = unlabelled;
  result.camera = evaluate_camera(truth.camera, estimate.camera, kMaxDifferenceNs);
  const ObjectContext context{truth.camera, estimate.camera,  truth.calibration, &reference.samples,
                              visibility,   kMaxDifferenceNs, options.body_frame};
  const Association association = associate_objects(reference, estimate, options.objects);
  const auto& [overlaps, matches, scored, left_out] = association;
  const ObjectOverlaps counted = counted_overlaps(reference, association, unlabelled);
  const std::vector<int> switches = identity_switches(counted, kAnyOverlap);
  for (std::size_t g = 0; g < truth.objects.size(); ++g) {
    if (!scored[g]) continue;
    const ObjectTrack& object = truth.objects[g];
    const ObjectTrack* track = matches[g] ? &estimate.objects[*matches[g]] : nullptr;
    const auto description = descriptions.find(object.id);
    result.objects.push_back(
        evaluate_object(object, description == descriptions.end() ? ObjectDescription{} : description->second,
                        track, states_of_match(overlaps, g, object.states.size(), matches[g]), context));
    result.objects.back().id_switches = switches[g];
  }
  if (unlabelled == Unlabelled::counted_false) result.unmatched_ids = unmatched_tracks(association, estimate);
  result.sizes = judged_sizes(association, estimate);
  result.tracking = tracking_scores(counted);
  return result;
}

const ObjectTrack& track_of(const Tracks& tracks, int id) {
  return *std::ranges::find(tracks.objects, id, &ObjectTrack::id);
}

// What hangs on the true surfaces: the points that are kept of them, and the depth of features. The frames of
// points and truth are laid on one another once for the whole track, where its poses usually have them
// (usual_body_offset): what the poses are off by frame by frame is APE's to say.
void compare_surfaces(const Truth& reference, const fs::path& estimate, double scale,
                      Evaluation& evaluation) {
  const auto& [truth, descriptions] = std::tie(reference.tracks, reference.descriptions);
  const auto features = read_features(estimate);
  for (ObjectEvaluation& object : evaluation.objects) {
    const auto described = descriptions.find(object.id);
    if (described == descriptions.end() || !object.matched_id) continue;
    const auto points = kept_points(estimate, object);
    const auto seen = features.find(*object.matched_id);
    if (!points && seen == features.end()) continue;
    const auto surface = true_surface(reference.folder, described->second);
    if (!surface) continue;
    if (points) object.surface = surface_error(*surface, *points, *object.truth_from_body, scale);
    if (seen != features.end() && truth.calibration)
      object.feature_depth = feature_depth_error(seen->second, *surface, track_of(truth, object.id),
                                                 truth.camera, *truth.calibration, kMaxDifferenceNs);
  }
}

// The estimated bodies, whatever their shape, against the true ones.
void compare_bodies(Truth& reference, const fs::path& folder, const Tracks& estimate, std::uint64_t seed,
                    Evaluation& evaluation) {
  const double scale = evaluation.alignment.truth_from_estimate.scale;
  for (ObjectEvaluation& object : evaluation.objects) {
    const TrueSolid* body = object.matched_id ? reference.body(object.id, seed) : nullptr;
    if (!body) continue;
    const ObjectTrack &true_track = track_of(reference.tracks, object.id),
                      &track = track_of(estimate, *object.matched_id);
    const auto mesh = estimated_mesh(folder, *object.matched_id, scale, seed);
    compare_solids(*body, mesh.get(), true_track, track, object);
    compare_body_surfaces(*body, mesh.get(), true_track, track, object);
  }
}

// The points of the estimate's map, carried into the true world, against the true map.
std::optional<MapComparison> compare_surroundings(const fs::path& truth, const fs::path& estimate,
                                                  const Alignment& truth_from_estimate) {
  const fs::path file = estimate / "map.ply";
  if (!fs::exists(file) || !fs::exists(truth / "map.bt")) return std::nullopt;
  const auto& [scale, pose] = truth_from_estimate;
  std::vector<Eigen::Vector3d> points;
  for (const Eigen::Vector3f& p : read_surface_ply(file).points)
    points.push_back(pose * (scale * p.cast<double>()).eval());
  return compare_map_points(truth / "map.bt", file, points, {});
}

// A camera that was never found has its own warning (stamp_check.h).
void warn_of_units(const fs::path& folder, const Tracks& truth, const Tracks& estimate,
                   const std::vector<ObjectEvaluation>& objects) {
  const auto positions = [](const Trajectory& camera) {
    std::vector<Pose> poses;
    for (const StampedPose& pose : camera) poses.push_back(pose.pose);
    return poses;
  };
  if (const auto fault = spread_fault(positions(truth.camera), positions(estimate.camera)))
    warn((folder / "camera.tum").string() + ": " + *fault);
  const bool none_is_matched =
      std::ranges::none_of(objects, [](const ObjectEvaluation& o) { return o.matched_id.has_value(); });
  if (const auto fault = size_fault(truth.objects, estimate.objects); fault && none_is_matched)
    warn((folder / "objects.csv").string() + ": " + *fault);
}

// Of one output of an estimate, which may be the estimate's own folder, into an existing folder.
void evaluate_output(Truth& reference, const fs::path& estimate_folder, const EvaluateOptions& options,
                     const fs::path& out) {
  const std::string of_estimate = scene_of(estimate_folder);
  require_one_scene({reference.folder, reference.scene}, {estimate_folder, of_estimate});
  const Tracks& truth = reference.tracks;
  const TruthNotes& notes = reference.notes;
  Tracks original = read_tracks(estimate_folder);
  require_tracks_of_solids(estimate_folder, original);
  if (notes.in_sensor_frame) original = in_sensor_frame(original);
  const std::string run_config = read_run_config(estimate_folder);
  const bool is_aligned = !truth.camera.empty() && !notes.in_sensor_frame && !camera_was_given(run_config);
  const AlignmentKind kind =
      options.alignment.value_or(is_aligned ? AlignmentKind::poses : AlignmentKind::none);
  const WorldAlignment alignment = align_world(kind, truth, original, kMaxDifferenceNs);
  const Tracks estimate = in_true_world(alignment, original);
  Evaluation evaluation = compare(reference, estimate, options);
  evaluation.alignment = alignment;
  if (notes.in_sensor_frame) evaluation.camera = {};  // its poses are the identity on both sides
  const bool has_any = std::ranges::any_of(
      truth.objects, [&](const ObjectTrack& object) { return reference.is_scored(object); });
  if (evaluation.objects.empty() && has_any)
    throw InputError(reference.folder,
                     fmt::format("has no object of --objects {}", to_string(options.objects)));
  if (!reference.knows_objects) evaluation.unmatched_ids.clear();  // no truth says that they belong to none
  const bool lists_objects = fs::exists(reference.folder / "objects.yaml") || !truth.objects.empty();
  if (reference.knows_objects && lists_objects && evaluation.unlabelled == Unlabelled::counted_false)
    evaluation.false_bodies = count_false_bodies(estimate.objects, evaluation.unmatched_ids);
  // that the camera was never found is a result, stamps of another recording are not
  if (!truth.camera.empty() && !notes.in_sensor_frame && evaluation.camera.pairs < kMinPairs &&
      estimate.camera.size() >= kMinPairs)
    throw InputError(
        estimate_folder / "camera.tum",
        fmt::format("{} of {} poses lie within 0.01 s of the truth's {}, at least {} are needed",
                    evaluation.camera.pairs, estimate.camera.size(), truth.camera.size(), kMinPairs));
  compare_surfaces(reference, estimate_folder, alignment.truth_from_estimate.scale, evaluation);
  compare_bodies(reference, estimate_folder, estimate, options.seed, evaluation);
  evaluation.map = compare_surroundings(reference.folder, estimate_folder, alignment.truth_from_estimate);
  evaluation.timing_ms = read_timing(estimate_folder);
  evaluation.usage = read_usage(estimate_folder);
  write_text(out / "evaluation.json", evaluation_json(evaluation, options, run_config));
  write_text(out / "frames.csv", frames_csv(evaluation.objects));
  write_text(out / "poses.csv", poses_csv(truth, estimate, evaluation));
  // an estimate of this program numbers its frames as its sequence does, which may be scans
  const bool same_frames = !reference.scene.empty() && of_estimate.empty();
  for (const std::string& fault :
       stamp_faults(estimate_folder, truth, original, kMaxDifferenceNs, same_frames))
    warn(fault);
  if (!fits_scale(kind)) warn_of_units(estimate_folder, truth, estimate, evaluation.objects);
}

}  // namespace

void evaluate(const fs::path& truth_folder, const fs::path& estimate_folder, const EvaluateOptions& options,
              const fs::path& out) {
  if (options.iou_samples < 1) throw InputError("iou samples: expected a number greater than 0");
  const bool is_simulation =
      !fs::exists(truth_folder / "camera.tum") && fs::is_directory(truth_folder / "truth");
  const fs::path truth_path = is_simulation ? truth_folder / "truth" : truth_folder;
  if (options.verify) require_unchanged_texts(truth_path);
  PendingFolder pending(out, "evaluation", options.force);
  const std::string scene = scene_of(truth_path);
  require_one_scene({truth_path, scene}, {estimate_folder, scene_of(estimate_folder)});
  Truth truth = read_truth(truth_path, scene, options);
  evaluate_output(truth, estimate_folder, options, pending.path());
  for (const char* output : kLaterOutputs) {
    if (!fs::is_directory(estimate_folder / output)) continue;
    fs::create_directory(pending.path() / output);
    evaluate_output(truth, estimate_folder / output, options, pending.path() / output);
  }
  pending.commit();
}

}  // namespace uniquadric
