#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/error.h"
#include "core/base/version.h"
#include "evaluation/evaluation_files.h"
#include "evaluation/pose_json_parts.h"
#include "evaluation/view_arc.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr int kSchema = 1;

template <typename T>
json or_null(const std::optional<T>& value) {
  return value ? json(*value) : json();
}

json to_json(const PoseStatistics& statistics) {
  return {{"translation_m", to_json(statistics.translation_m)},
          {"rotation_rad", to_json(statistics.rotation_rad)}};
}

// Statistics of what `figure` gives for the frames that have it.
template <typename Figure>
json over_frames(const ObjectEvaluation& object, const Figure& figure) {
  std::vector<double> values;
  for (const ObjectFrame& frame : object.frames)
    if (const std::optional<double> value = figure(frame)) values.push_back(*value);
  return to_json(statistics(values));
}

json pose_errors(const ObjectEvaluation& object, std::optional<PoseError> ObjectFrame::*errors) {
  if (object.matched_frames < kMinPairs) return to_json(PoseStatistics{});
  std::vector<PoseError> values;
  for (const ObjectFrame& frame : object.frames)
    if (frame.*errors) values.push_back(*(frame.*errors));
  return to_json(pose_statistics(values));
}

json monte_carlo(const ObjectEvaluation& object, const EvaluateOptions& options) {
  double sum = 0, error = 0;
  for (const ObjectFrame& frame : object.frames) {
    if (!frame.iou3d_monte_carlo) continue;
    sum += frame.iou3d_monte_carlo->iou;
    error += frame.iou3d_monte_carlo->standard_error;
  }
  if (object.matched_frames == 0) return nullptr;
  const double n = static_cast<double>(object.matched_frames);
  // All frames use the same points, so their errors do not average out: the mean's is bounded by the mean
  // error.
  return {{"mean", sum / n}, {"stderr", error / n}, {"samples", options.iou_samples}, {"seed", options.seed}};
}

// Of the frames after the object's start.
json after_start(const ObjectEvaluation& object, std::optional<double> ObjectFrame::*member) {
  std::vector<double> values;
  for (const ObjectFrame& frame : frames_after_start(object.frames))
    if (const auto value = frame.*member) values.push_back(*value);
  return to_json(statistics(values));
}

// Of the frames by which the camera has seen a wide arc of the object.
json from_wide_arc(const ObjectEvaluation& object, std::optional<double> ObjectFrame::*member) {
  return over_frames(object, [member](const ObjectFrame& frame) {
    return frame.arc_deg && *frame.arc_deg >= kWideArc_deg ? frame.*member : std::nullopt;
  });
}

// The same figures over some of an object's frames.
json over_part(std::vector<ObjectFrame> frames) {
  ObjectEvaluation part;
  part.frames = std::move(frames);
  for (const ObjectFrame& frame : part.frames) part.matched_frames += frame.estimate ? 1 : 0;
  return {{"frames", part.frames.size()},
          {"matched_frames", part.matched_frames},
          {"ape", pose_errors(part, &ObjectFrame::ape)},
          {"rpe", pose_errors(part, &ObjectFrame::rpe)},
          {"iou3d_solid", over_frames(part, [](const ObjectFrame& frame) { return frame.iou3d_solid; })},
          {"iou2d", over_frames(part, [](const ObjectFrame& frame) { return frame.iou2d; })}};
}

// Null where the truth says nothing of visibility.
json in_view(const ObjectEvaluation& object) {
  if (!says_what_is_visible(object.frames)) return nullptr;
  return over_part(frames_in_view(object.frames));
}

json semi_axes_errors(const ObjectEvaluation& object) {
  json errors;
  for (int i = 0; i < 3; ++i)
    errors[std::string(1, "xyz"[i])] =
        over_frames(object, [i](const ObjectFrame& frame) -> std::optional<double> {
          if (!frame.estimate) return std::nullopt;
          return frame.estimate->semi_axes_m[i] - frame.true_semi_axes_m[i];
        });
  return errors;
}

// Errors over the sigmas that were stated of them.
json consistency(const ObjectEvaluation& object) {
  const auto of_part = [&](std::optional<double> ErrorsInSigmas::*part) {
    return over_frames(object, [part](const ObjectFrame& frame) { return frame.in_sigmas.*part; });
  };
  return {{"translation", of_part(&ErrorsInSigmas::translation)},
          {"rotation", of_part(&ErrorsInSigmas::rotation)},
          {"semi_axes", of_part(&ErrorsInSigmas::semi_axes)}};
}

json to_json(const std::optional<SurfaceError>& surface) {
  if (!surface) return nullptr;
  json error = to_json(std::optional(surface->error_m));
  error["quantile_90"] = surface->quantile_90_m;
  const Eigen::Vector3d& t = surface->points_from_truth.translation;
  const Eigen::Quaterniond& q = surface->points_from_truth.rotation;
  return {{"error_m", error},
          {"completeness", surface->completeness},
          {"within_m", surface->within_m},
          {"points_from_truth",
           {{"position_m", {t.x(), t.y(), t.z()}}, {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}}}}};
}

json to_json(const std::optional<FeatureDepthError>& depth) {
  if (!depth) return nullptr;
  json error = to_json(depth->error_m);
  if (depth->quantile_90_m) error["quantile_90"] = *depth->quantile_90_m;
  return {{"error_m", error},
          {"coverage", depth->coverage},
          {"sightings", depth->sightings},
          {"off_body", depth->off_body}};
}

json solid_iou_json(const ObjectEvaluation& object) {
  if (!object.solid) return nullptr;
  json result = over_frames(object, [](const ObjectFrame& frame) { return frame.iou3d_solid; });
  result["mean"] = object.solid->iou.mean;
  result["stderr"] = object.solid->iou.standard_error;
  result["truth_solid"] = object.solid->truth;
  result["estimate_solid"] = object.solid->estimate;
  return result;
}

// Null where the truth has no surface.
json surface_f1_json(const ObjectEvaluation& object) {
  if (!object.surface_tolerance_m) return nullptr;
  json result = over_frames(object, [](const ObjectFrame& frame) { return frame.surface_f1; });
  result["within_m"] = *object.surface_tolerance_m;
  return result;
}

json to_json(const ObjectEvaluation& object, const EvaluateOptions& options) {
  const auto figure = [&](std::optional<double> ObjectFrame::*member) {
    return over_frames(object, [member](const ObjectFrame& frame) { return frame.*member; });
  };
  json result = {{"id", object.id},
                 {"name", object.name},
                 {"matched_id", or_null(object.matched_id)},
                 {"frames", object.frames.size()},
                 {"matched_frames", object.matched_frames},
                 {"visible_frames", object.presence.visible_frames},
                 {"coverage", or_null(object.presence.coverage)},
                 {"coverage_of_all_frames", or_null(object.presence.coverage_of_all_frames)},
                 {"longest_gap_s", or_null(object.presence.longest_gap_s)},
                 {"id_switches", object.id_switches},
                 {"relabel_flips", object.relabel_flips},
                 {"symmetry", to_string(object.symmetry.kind)},
                 {"ape", pose_errors(object, &ObjectFrame::ape)},
                 {"ape_of_distance", figure(&ObjectFrame::ape_of_distance)},
                 {"rpe", pose_errors(object, &ObjectFrame::rpe)},
                 {"motion_error", pose_errors(object, &ObjectFrame::motion)},
                 {"drift", to_json(object.drift)},
                 {"iou3d", figure(&ObjectFrame::iou3d)},
                 {"iou3d_solid", solid_iou_json(object)},
                 {"surface_f1", surface_f1_json(object)},
                 {"chamfer_m", figure(&ObjectFrame::chamfer_m)},
                 {"iou3d_box", figure(&ObjectFrame::iou3d_box)},
                 {"iou3d_monte_carlo", monte_carlo(object, options)},
                 {"iou2d", figure(&ObjectFrame::iou2d)},
                 {"iou2d_ellipse", figure(&ObjectFrame::iou2d_ellipse)},
                 {"iou3d_after_3s", after_start(object, &ObjectFrame::iou3d)},
                 {"iou2d_after_3s", after_start(object, &ObjectFrame::iou2d)},
                 {"iou3d_from_40deg", from_wide_arc(object, &ObjectFrame::iou3d)},
                 {"semi_axes_change_occluded_max", or_null(semi_axes_change_occluded(object.frames))},
                 {"d_shape_m", figure(&ObjectFrame::d_shape_m)},
                 {"surface", to_json(object.surface)},
                 {"feature_depth", to_json(object.feature_depth)},
                 {"semi_axes_error_m", semi_axes_errors(object)},
                 {"consistency", consistency(object)},
                 {"in_view", in_view(object)},
                 {"after_3s", over_part(frames_after_start(object.frames))}};
  if (object.matched_frames < kMinPairs) {
    result["drift"] = result["ape"]["rotation_naive_rad"] = result["ape"]["rotation_symmetric_rad"] = nullptr;
    return result;
  }
  result["ape"]["rotation_naive_rad"] = figure(&ObjectFrame::ape_rotation_naive_rad);
  result["ape"]["rotation_symmetric_rad"] = figure(&ObjectFrame::rotation_symmetric_rad);
  return result;
}

json to_json(const WorldAlignment& alignment) {
  json result = to_json(alignment.kind, alignment.truth_from_estimate, "truth_from_estimate");
  if (alignment.kind == AlignmentKind::poses) result["lever_m"] = alignment.lever_m;
  return result;
}

json to_json(const CameraEvaluation& camera) {
  return {{"frames", camera.truth_poses},
          {"pairs", camera.pairs},
          {"coverage", camera.truth_poses > 0 ? json(camera.coverage) : json()},
          {"ape", to_json(camera.ape)},
          {"rpe", to_json(camera.rpe)},
          {"drift", to_json(camera.drift)}};
}

json to_json(const std::vector<SizeSteadiness>& sizes) {
  json list = json::array();
  for (const SizeSteadiness& size : sizes) {
    const Eigen::Vector3d& a = size.semi_axes_m;
    list.push_back({{"id", size.id},
                    {"states", size.states},
                    {"semi_axes_median_m", {a.x(), a.y(), a.z()}},
                    {"spread", size.spread}});
  }
  return list;
}

json to_json(const std::optional<MapComparison>& map) {
  if (!map) return nullptr;
  json result = json::parse(figures_json(figures(*map)));
  for (const char* of_files : {"schema", "program"}) result.erase(of_files);
  return result;
}

json tracking_json(const Evaluation& evaluation) {
  json result = {{"hota", nullptr}, {"mota", nullptr}, {"idf1", nullptr}};
  result["similarity"] = "iou3d";
  result["threshold"] = kClearThreshold;
  result["unmatched_ids"] = evaluation.unmatched_ids;
  result["false_bodies"] = or_null(evaluation.false_bodies);
  if (!evaluation.tracking) return result;
  result["hota"] = evaluation.tracking->hota;
  result["mota"] = evaluation.tracking->mota;
  result["idf1"] = evaluation.tracking->idf1;
  return result;
}

// A figure that is no number would be written as none. Inputs are bounded so that there is none; should one
// come about, its name is better than a file that hides it.
void require_finite(const json& figures, const std::string& name) {
  if (figures.is_number_float() && !std::isfinite(figures.get<double>()))
    throw InputError(name + ": comes out as no finite number");
  if (!figures.is_structured()) return;
  for (const auto& [key, value] : figures.items())
    require_finite(value, name.empty() ? key : name + "." + key);
}

}  // namespace

std::string evaluation_json(const Evaluation& evaluation, const EvaluateOptions& options,
                            const std::string& run_config_json) {
  const json run_config = json::parse(run_config_json);
  json root = {{"schema", kSchema},
               {"program", kProgram},
               {"alignment", to_json(evaluation.alignment)},
               {"camera", to_json(evaluation.camera)},
               {"map", to_json(evaluation.map)},
               {"tracking", tracking_json(evaluation)}};
  root["objects"] = json::array();
  for (const ObjectEvaluation& object : evaluation.objects)
    root["objects"].push_back(to_json(object, options));
  root["estimated_objects"] = to_json(evaluation.sizes);
  root["size_spread_mean"] = or_null(mean_spread(evaluation.sizes));
  root["timing_ms"] = json::object();
  for (const auto& [stage, values] : evaluation.timing_ms)
    root["timing_ms"][stage] = to_json(statistics(values));
  if (const auto& usage = evaluation.usage)
    root["usage"] = {{"wall_time_s", usage->wall_time_s},
                     {"cpu_time_s", usage->cpu_time_s},
                     {"peak_memory_mb", usage->peak_memory_mb}};
  require_finite(root, "");
  root["config"] = {{"estimate", run_config},
                    {"evaluate",
                     {{"body_frame", to_string(options.body_frame)},
                      {"objects", to_string(options.objects)},
                      {"unlabelled", evaluation.unlabelled == Unlabelled::ignored ? "ignore" : "false"},
                      {"iou_samples", options.iou_samples},
                      {"seed", options.seed}}}};
  root["seed"] = run_config.is_object() && run_config.contains("seed") ? run_config["seed"] : json();
  return root.dump(2) + "\n";
}

}  // namespace uniquadric
