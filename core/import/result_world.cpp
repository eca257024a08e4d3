#include "core/import/result_world.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "core/base/warning.h"
#include "core/import/result.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

Trajectory camera_at_frames(const Trajectory& camera, const Sequence& sequence, const std::string& name) {
  Tracks tracks;
  tracks.camera = camera;
  return at_frames(tracks, sequence, name).camera;
}

ObjectState state_of(const BoxInCamera& box, const StampedPose& camera) {
  ObjectState state;
  state.frame = box.frame;
  state.stamp_ns = camera.stamp_ns;
  state.ellipsoid = {camera.pose * box.camera_from_object, box.shape.semi_axes_m};
  state.ellipsoid.world_from_object.rotation.normalize();
  state.exponents = box.shape.exponents;
  state.profile_axis = box.shape.profile_axis;
  return state;
}

}  // namespace

Trajectory camera_of_result(const fs::path& file, const Sequence& sequence, const std::string& name) {
  if (fs::exists(file)) return camera_at_frames(read_tum(file), sequence, file.string());
  if (sequence.given_camera) {
    warn(fmt::format("{}: has no poses of the camera: the sequence's given ones are taken", name));
    return camera_at_frames(*sequence.given_camera, sequence, "the sequence's given camera");
  }
  warn(
      fmt::format("{}: has no poses of the camera, and the sequence gives none: the result is in the "
                  "sensor's frame",
                  name));
  Trajectory camera;
  for (const std::int64_t stamp_ns : observed_ns(sequence)) camera.push_back({stamp_ns, Pose()});
  return camera;
}

Tracks placed_in_world(std::vector<BoxInCamera> boxes, const Trajectory& camera, const Sequence& sequence,
                       const std::string& name) {
  const std::vector<std::int64_t> stamps_ns = observed_ns(sequence);
  std::map<std::int64_t, const StampedPose*> pose_at;
  for (const StampedPose& pose : camera) pose_at.emplace(pose.stamp_ns, &pose);
  std::ranges::sort(boxes, {}, &BoxInCamera::frame);
  std::map<int, ObjectTrack> tracks;
  std::size_t left_out = 0;
  for (const BoxInCamera& box : boxes) {
    const auto pose = pose_at.find(stamps_ns.at(static_cast<std::size_t>(box.frame)));
    if (pose == pose_at.end()) {
      ++left_out;
      continue;
    }
    ObjectTrack& track = tracks[box.id];
    track.id = box.id;
    track.states.push_back(state_of(box, *pose->second));
  }
  if (left_out > 0)
    warn(fmt::format("{}: {} of {} boxes are left out: the camera has no pose at their frames", name,
                     left_out, boxes.size()));
  Tracks result;
  result.camera = camera;
  for (auto& [id, track] : tracks) result.objects.push_back(std::move(track));
  return result;
}

}  // namespace uniquadric
