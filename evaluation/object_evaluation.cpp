#include "evaluation/object_evaluation.h"

#include <cassert>

#include "evaluation/image_overlap.h"
#include "evaluation/iou/ellipsoid_iou.h"

namespace uniquadric {
namespace {

constexpr std::size_t kFitFrames =
    10;  // SPEC 6: a free body rotation is fitted on the first 10 matched frames

// The matched frames of one object, in order: what its axes' names are decided on.
struct Matched {
  std::vector<std::size_t> frame;  // index into the truth's states
  std::vector<Ellipsoid> truth, estimate;
};

Matched collect_matched(const ObjectTrack& truth, const ObjectTrack* track,
                        const std::vector<std::optional<std::size_t>>& states) {
  Matched matched;
  for (std::size_t k = 0; track && k < states.size(); ++k) {
    if (!states[k]) continue;
    matched.frame.push_back(k);
    matched.truth.push_back(truth.states[k].ellipsoid);
    matched.estimate.push_back(track->states[*states[k]].ellipsoid);
  }
  return matched;
}

Eigen::Matrix3d fit_symmetry(BodySymmetry symmetry, const std::vector<Ellipsoid>& estimate,
                             const std::vector<Ellipsoid>& truth) {
  const std::size_t count = symmetry == BodySymmetry::box ? truth.size() : std::min(truth.size(), kFitFrames);
  std::vector<Eigen::Matrix3d> from, to;
  for (std::size_t i = 0; i < count; ++i) {
    from.push_back(estimate[i].world_from_object.rotation.toRotationMatrix());
    to.push_back(truth[i].world_from_object.rotation.toRotationMatrix());
  }
  const Eigen::Vector3d& axes = truth.front().semi_axes_m;
  return best_symmetry_rotation(symmetry, axes, classify_axes(axes).unique_axis, from, to);
}

Ellipsoid turned(const Ellipsoid& ellipsoid, BodySymmetry symmetry, const Eigen::Matrix3d& rotation) {
  if (symmetry == BodySymmetry::box) return relabelled(ellipsoid, rotation);
  if (rotation == Eigen::Matrix3d::Identity()) return ellipsoid;
  Ellipsoid result = ellipsoid;  // the semi-axes keep their names: the shape is the same after any such turn
  result.world_from_object.rotation = ellipsoid.world_from_object.rotation * Eigen::Quaterniond(rotation);
  return result;
}

// Renames the track's axes once, then turns its body frame within the true shape's symmetry.
std::vector<Ellipsoid> settle_axes(const Matched& matched, ObjectEvaluation& result) {
  std::vector<Ellipsoid> settled;
  if (matched.truth.empty()) return settled;
  const Eigen::Matrix3d names = best_relabelling(matched.estimate, matched.truth);
  for (std::size_t i = 0; i < matched.truth.size(); ++i) {
    const bool flipped = best_relabelling({matched.estimate[i]}, {matched.truth[i]}) != names;
    result.relabel_flips += flipped ? 1 : 0;
    settled.push_back(relabelled(matched.estimate[i], names));
  }
  const Eigen::Matrix3d rotation = fit_symmetry(result.symmetry, settled, matched.truth);
  for (Ellipsoid& ellipsoid : settled) ellipsoid = turned(ellipsoid, result.symmetry, rotation);
  return settled;
}

void fill_single_frame(const Ellipsoid& truth, const Ellipsoid& original, const Ellipsoid& settled,
                       const ObjectContext& context, ObjectFrame& frame) {
  frame.estimate = settled;
  frame.ape = absolute_error(truth.world_from_object, settled.world_from_object);
  frame.ape_rotation_naive_rad =
      absolute_error(truth.world_from_object, original.world_from_object).rotation_rad;
  frame.rotation_symmetric_rad = symmetric_rotation_error(settled, truth);
  frame.iou3d = ellipsoid_iou(truth, original);
  frame.iou3d_monte_carlo = ellipsoid_iou_monte_carlo(truth, original, *context.samples);
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

void fill_relative(const ObjectTrack& truth, std::vector<ObjectFrame>& frames) {
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (!frames[k - 1].estimate || !frames[k].estimate) continue;
    const Pose& a = truth.states[k - 1].ellipsoid.world_from_object;
    const Pose& b = truth.states[k].ellipsoid.world_from_object;
    const Pose& p = frames[k - 1].estimate->world_from_object;
    const Pose& q = frames[k].estimate->world_from_object;
    frames[k].rpe = relative_error(a, b, p, q);
    frames[k].motion = object_motion_error(a, b, p, q);
  }
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

BodySymmetry body_symmetry(const std::string& shape, const Eigen::Vector3d& semi_axes_m) {
  const bool round = shape == "ball" || shape == "ellipsoid" || shape == "cylinder";
  const AxesClass axes = classify_axes(semi_axes_m).kind;
  if (!round || axes == AxesClass::triaxial) return BodySymmetry::box;
  // A cylinder as high as it is wide turns freely about its own axis alone, but which axis that is cannot be
  // told from its extents: it counts as a box, whose symmetries hold for it.
  if (axes == AxesClass::sphere) return shape == "cylinder" ? BodySymmetry::box : BodySymmetry::ball;
  return BodySymmetry::revolution;
}

ObjectEvaluation evaluate_object(const ObjectTrack& truth, const std::string& shape, const ObjectTrack* track,
                                 const std::vector<std::optional<std::size_t>>& matched_states,
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
    }
  }
  if (result.frames.empty()) return result;
  result.symmetry = body_symmetry(shape, result.frames.front().true_semi_axes_m);
  const Matched matched = collect_matched(truth, track, matched_states);
  const std::vector<Ellipsoid> settled = settle_axes(matched, result);
  for (std::size_t i = 0; i < settled.size(); ++i) {
    ObjectFrame& frame = result.frames[matched.frame[i]];
    fill_single_frame(matched.truth[i], matched.estimate[i], settled[i], context, frame);
    fill_image_overlap(matched.truth[i], matched.estimate[i], context, frame);
  }
  fill_relative(truth, result.frames);
  result.matched_frames = settled.size();
  result.presence = object_presence(result.frames);
  result.drift = object_drift(truth, result.frames);
  return result;
}

}  // namespace uniquadric
