#include "evaluation/object_evaluation.h"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "core/geometry/box_symmetry.h"
#include "core/sequence/stamps.h"
#include "evaluation/align/symmetry.h"
#include "evaluation/association/stamps.h"
#include "evaluation/image_overlap.h"
#include "evaluation/iou/box_iou.h"
#include "evaluation/stretches.h"
#include "evaluation/view_arc.h"

namespace uniquadric {
namespace {

// The matched frames of one object, in order: what its axes' names are decided on.
struct Matched {
  std::vector<std::size_t> frame;  // index into the truth's states
  std::vector<Ellipsoid> truth, estimate;
  std::vector<std::optional<ObjectStatus>> status;  // of all the truth's states; empty without a match
};

Matched collect_matched(const ObjectTrack& truth, const ObjectTrack* track,
                        const std::vector<std::optional<MatchedState>>& states) {
  Matched matched;
  matched.status.resize(states.size());
  for (std::size_t k = 0; track && k < states.size(); ++k) {
    if (!states[k]) continue;
    matched.frame.push_back(k);
    matched.status[k] = track->states[states[k]->index].status;
    matched.truth.push_back(truth.states[k].ellipsoid);
    matched.estimate.push_back(track->states[states[k]->index].ellipsoid);
  }
  return matched;
}

std::vector<Pose> poses_of(const std::vector<Ellipsoid>& ellipsoids) {
  std::vector<Pose> result;
  for (const Ellipsoid& ellipsoid : ellipsoids) result.push_back(ellipsoid.world_from_object);
  return result;
}

Ellipsoid moved(const Ellipsoid& ellipsoid, const std::optional<Pose>& offset) {
  if (!offset) return ellipsoid;
  return {ellipsoid.world_from_object * *offset, ellipsoid.semi_axes_m};
}

// The one body-frame transform of the whole track, where one is asked for.
std::optional<Pose> frame_offset(BodyFrame kind, const std::vector<Ellipsoid>& truth,
                                 const std::vector<Ellipsoid>& settled) {
  if (kind == BodyFrame::none) return std::nullopt;
  return body_frame_offset(kind, poses_of(truth), poses_of(settled));
}

StatedSigmas stated_sigmas(const Vector9d& variances) {
  const auto sigma_of = [&](Eigen::Index first) -> std::optional<double> {
    const double variance = variances.segment<3>(first).sum();  // NaN where one is not stated
    return variance > 0 ? std::optional(std::sqrt(variance)) : std::nullopt;
  };
  return {sigma_of(3), sigma_of(6), sigma_of(0)};
}

// Along the axes of the estimate as it came, of which its variances are; `settled` differs by the names of
// the axes and by turns that the shape's symmetry leaves open.
ErrorsInSigmas errors_in_sigmas(const Ellipsoid& truth, const Ellipsoid& original, const Ellipsoid& settled,
                                const Vector9d& variances) {
  const auto in_sigmas = [&](Eigen::Index first, const Eigen::Vector3d& error) -> std::optional<double> {
    const double mean = (error.array().square() / variances.segment<3>(first).array()).mean();
    return std::isfinite(mean) ? std::optional(std::sqrt(mean)) : std::nullopt;
  };
  const Pose &t = truth.world_from_object, &o = original.world_from_object, &s = settled.world_from_object;
  const Eigen::Matrix3d original_from_settled = (o.rotation.conjugate() * s.rotation).toRotationMatrix();
  Eigen::Vector3d semi_axes;
  for (int i = 0; i < 3; ++i) {
    Eigen::Index same = 0;
    original_from_settled.row(i).cwiseAbs().maxCoeff(&same);
    semi_axes[i] = settled.semi_axes_m[same] - truth.semi_axes_m[same];
  }
  return {in_sigmas(3, o.rotation.conjugate() * (s.translation - t.translation)),
          in_sigmas(6, original_from_settled * log_so3(s.rotation.conjugate() * t.rotation)),
          in_sigmas(0, semi_axes)};
}

void fill_single_frame(const Ellipsoid& truth, const Ellipsoid& original, const Ellipsoid& settled,
                       const ShapeSymmetry& symmetry, const ObjectContext& context, ObjectFrame& frame) {
  frame.estimate = settled;
  frame.ape = absolute_error(truth.world_from_object, settled.world_from_object);
  frame.ape_rotation_naive_rad =
      absolute_error(truth.world_from_object, original.world_from_object).rotation_rad;
  frame.rotation_symmetric_rad = symmetric_rotation_error(settled, truth);
  frame.iou3d_monte_carlo = ellipsoid_iou_monte_carlo(truth, original, *context.samples);
  frame.iou3d_box = symmetric_box_iou(truth, relabel_axes(original, frame.names), symmetry);
  frame.d_shape_m = shape_distance_m(original, truth);
}

void fill_image_overlap(const Ellipsoid& truth, const Ellipsoid& original, const ObjectContext& context,
                        ObjectFrame& frame) {
  if (!context.calibration) return;
  const auto limit = context.max_difference_ns;
  const Pose* true_camera = nearest_pose(context.truth_camera, frame.stamp_ns, limit);
  const Pose* estimated_camera = nearest_pose(context.estimate_camera, frame.stamp_ns, limit);
  if (!true_camera || !estimated_camera) return;
  const ImageOverlap overlap =
      overlap_in_image(*context.calibration, {*true_camera, truth}, {*estimated_camera, original});
  frame.iou2d = overlap.rectangle_iou;
  frame.iou2d_ellipse = overlap.ellipse_iou;
}

// Both states of a pair bear the names of the second one's stretch: a change of names between them is no
// error, and a flip of the estimate is one.
void fill_relative(const ObjectTrack& truth, const Matched& matched, const std::vector<AxesChange>& changes,
                   const std::optional<Pose>& offset, std::vector<ObjectFrame>& frames) {
  const std::vector<bool> is_next = are_next_frames(stamps_of(truth.states));
  for (std::size_t i = 1; i < matched.frame.size(); ++i) {
    const std::size_t k = matched.frame[i];
    if (!is_next[k] || matched.frame[i - 1] + 1 != k) continue;
    const Pose& a = truth.states[k - 1].ellipsoid.world_from_object;
    const Pose& b = truth.states[k].ellipsoid.world_from_object;
    const Pose p = moved(changed_axes(matched.estimate[i - 1], changes[i]), offset).world_from_object;
    const Pose& q = frames[k].estimate->world_from_object;
    frames[k].rpe = relative_error(a, b, p, q);
    frames[k].motion = object_motion_error(a, b, p, q);
  }
}

// From the true poses: where the camera is does not depend on the estimate.
void fill_views(const ObjectTrack& truth, const ObjectContext& context, std::vector<ObjectFrame>& frames) {
  std::vector<std::optional<Eigen::Vector3d>> directions(frames.size());
  for (std::size_t k = 0; k < frames.size(); ++k) {
    const Pose* camera = nearest_pose(context.truth_camera, frames[k].stamp_ns, context.max_difference_ns);
    if (!camera) continue;
    const Pose& object = truth.states[k].ellipsoid.world_from_object;
    const double distance_m = (object.translation - camera->translation).norm();
    if (frames[k].ape && distance_m > 0)
      frames[k].ape_of_distance = frames[k].ape->translation_m / distance_m;
    if (frames[k].visible) directions[k] = view_direction(object, *camera);
  }
  const auto arcs = view_arcs_deg(directions);
  for (std::size_t k = 0; k < frames.size(); ++k) frames[k].arc_deg = arcs[k];
}

std::optional<Drift> object_drift(const ObjectTrack& truth, const std::vector<ObjectFrame>& frames) {
  PosePairs poses;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!frames[k].estimate) continue;
    poses.stamps_ns.push_back(frames[k].stamp_ns);
    poses.reference.push_back(truth.states[k].ellipsoid.world_from_object);
    poses.estimate.push_back(frames[k].estimate->world_from_object);
  }
  return maximum_drift(poses);
}

}  // namespace

double symmetric_box_iou(const Ellipsoid& truth, const Ellipsoid& named, const ShapeSymmetry& symmetry) {
  const double as_it_is = box_iou(truth, named);
  if (symmetry.kind != BodySymmetry::revolution && symmetry.kind != BodySymmetry::sphere) return as_it_is;
  const Pose& pose = truth.world_from_object;
  const Eigen::Matrix3d turn = best_symmetry_rotation(symmetry, truth.semi_axes_m,
                                                      {named.world_from_object.rotation.toRotationMatrix()},
                                                      {pose.rotation.toRotationMatrix()});
  const Pose turned{pose.rotation * Eigen::Quaterniond(Eigen::Matrix3d(turn.transpose())), pose.translation};
  return std::max(as_it_is, box_iou({turned, truth.semi_axes_m}, named));
}

ObjectEvaluation evaluate_object(const ObjectTrack& truth, const ObjectDescription& description,
                                 const ObjectTrack* track,
                                 const std::vector<std::optional<MatchedState>>& matched_states,
                                 const ObjectContext& context) {
  assert(matched_states.size() == truth.states.size());
  ObjectEvaluation result;
  result.id = truth.id;
  result.name = truth.name;
  if (track) result.matched_id = track->id;
  for (const ObjectState& state : truth.states) {
    ObjectFrame& frame = result.frames.emplace_back();
    frame.frame = state.frame;
    frame.stamp_ns = state.stamp_ns;
    frame.true_semi_axes_m = state.ellipsoid.semi_axes_m;
    if (const auto seen = context.visibility.find({state.frame, truth.id});
        seen != context.visibility.end()) {
      frame.visible_fraction = seen->second.visible_fraction;
      frame.visible = is_visible(seen->second);
      frame.occluded = is_occluded(seen->second);
    }
  }
  if (result.frames.empty()) return result;
  result.symmetry =
      shape_symmetry(description.shape, description.symmetry, result.frames.front().true_semi_axes_m);
  const Matched matched = collect_matched(truth, track, matched_states);
  if (!matched.frame.empty())
    result.truth_from_body = usual_body_offset(poses_of(matched.truth), poses_of(matched.estimate),
                                               matched.truth.front().semi_axes_m.norm());
  SettledTrack settled = settle_axes(
      result.symmetry, matched.estimate, matched.truth,
      later_stretch_starts(stretch_frames(truth.id, result.frames, matched.status, context.visibility)));
  const auto offset = frame_offset(context.body_frame, matched.truth, settled.estimate);
  for (Ellipsoid& ellipsoid : settled.estimate) ellipsoid = moved(ellipsoid, offset);
  result.relabel_flips = settled.relabel_flips;
  for (std::size_t i = 0; i < settled.estimate.size(); ++i) {
    ObjectFrame& frame = result.frames[matched.frame[i]];
    const MatchedState& matched_state = *matched_states[matched.frame[i]];
    const ObjectState& state = track->states[matched_state.index];
    frame.names = settled.changes[i].names;
    frame.state = matched_state.index;
    frame.iou3d = matched_state.iou3d;
    if (state.status == ObjectStatus::occluded) frame.occluded = true;
    frame.stated = stated_sigmas(state.covariance_diagonal);
    frame.in_sigmas = errors_in_sigmas(matched.truth[i], matched.estimate[i], settled.estimate[i],
                                       state.covariance_diagonal);
    fill_single_frame(matched.truth[i], matched.estimate[i], settled.estimate[i], result.symmetry, context,
                      frame);
    fill_image_overlap(matched.truth[i], matched.estimate[i], context, frame);
  }
  fill_relative(truth, matched, settled.changes, offset, result.frames);
  fill_views(truth, context, result.frames);
  result.matched_frames = settled.estimate.size();
  result.presence = object_presence(result.frames);
  result.drift = object_drift(truth, result.frames);
  return result;
}

}  // namespace uniquadric
