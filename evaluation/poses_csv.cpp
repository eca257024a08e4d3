#include <fmt/format.h>
#include <fmt/ranges.h>

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
    text += fmt::format("{},camera,0,{},{},,,\n", source, stamped.stamp_ns, pose_cells(stamped.pose));
}

void add_track(const char* source, const char* subject, int id, const ObjectTrack& track, std::string& text) {
  for (const ObjectState& state : track.states) {
    const Eigen::Vector3d& axes_m = state.ellipsoid.semi_axes_m;
    text += fmt::format("{},{},{},{},{},{:.9g},{:.9g},{:.9g}\n", source, subject, id, state.stamp_ns,
                        pose_cells(state.ellipsoid.world_from_object), axes_m.x(), axes_m.y(), axes_m.z());
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
