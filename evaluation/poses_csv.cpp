#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>

#include "evaluation/evaluation_files.h"

namespace uniquadric {
namespace {

std::string pose_cells(const Pose& pose) {
  const auto& t = pose.translation;
  const auto& q = pose.rotation;
  return fmt::format("{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}", t.x(), t.y(), t.z(), q.x(), q.y(),
                     q.z(), q.w());
}

void add_camera(const char* source, const Trajectory& camera, std::string& text) {
  for (const StampedPose& stamped : camera)
    text += fmt::format("{},camera,0,{},{},,,,,,,,,,\n", source, stamped.stamp_ns, pose_cells(stamped.pose));
}

std::string solid_cells(const ObjectState& state) {
  std::string text = fmt::format("{:.9g},{:.9g},{:.9g},{}", state.exponents.outline, state.exponents.upper,
                                 state.exponents.lower, state.profile_axis);
  for (int i = 0; i < 3; ++i) {
    const double variance = state.covariance_diagonal[3 + i];
    text += variance >= 0 ? fmt::format(",{:.9g}", std::sqrt(variance)) : ",";
  }
  return text;
}

void add_track(const char* source, const char* subject, int id, const ObjectTrack& track, std::string& text) {
  for (const ObjectState& state : track.states) {
    const Eigen::Vector3d& axes_m = state.ellipsoid.semi_axes_m;
    text += fmt::format("{},{},{},{},{},{:.9g},{:.9g},{:.9g},{}\n", source, subject, id, state.stamp_ns,
                        pose_cells(state.ellipsoid.world_from_object), axes_m.x(), axes_m.y(), axes_m.z(),
                        solid_cells(state));
  }
}

// The true object that a track was matched to.
std::optional<int> truth_of(int track_id, const std::vector<ObjectEvaluation>& objects) {
  for (const ObjectEvaluation& object : objects)
    if (object.matched_id == track_id) return object.id;
  return std::nullopt;
}

}  // namespace

std::string poses_csv(const Tracks& truth, const Tracks& estimate, const Evaluation& evaluation) {
  std::string text = fmt::format("{}\n", fmt::join(kPosesColumns, ","));
  add_camera("truth", truth.camera, text);
  for (const ObjectTrack& object : truth.objects) add_track("truth", "object", object.id, object, text);
  add_camera("estimate", estimate.camera, text);
  for (const ObjectTrack& track : estimate.objects) {
    const auto id = truth_of(track.id, evaluation.objects);
    add_track("estimate", id ? "object" : "unmatched", id.value_or(track.id), track, text);
  }
  return text;
}

}  // namespace uniquadric
