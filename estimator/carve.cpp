#include "estimator/carve.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <opencv2/core.hpp>
#include <utility>
#include <vector>

#include "core/sequence/object_body.h"
#include "estimator/shape/body_carving.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr double kNoisePerRange = 0.005;  // ours: of a depth camera, along the line of sight

struct CarvedBody {
  int id;
  BodyCarving carving;
  std::map<std::int64_t, Pose> world_from_object;  // in the frames that it is carved by
};

// A body that was begun anew has another frame in each life: one mesh cannot be all of them.
bool has_one_shape(const ObjectTrack& track) {
  return std::ranges::all_of(track.states, [&](const ObjectState& state) {
    return body_of(state) == body_of(track.states.front());
  });
}

std::vector<CarvedBody> bodies_to_carve(const std::vector<ObjectTrack>& tracks,
                                        const std::map<std::int64_t, const FrameInfo*>& frames,
                                        double noise_per_range, const CarvingOptions& options) {
  std::vector<CarvedBody> bodies;
  for (const ObjectTrack& track : tracks) {
    if (track.states.empty() || !has_one_shape(track)) continue;
    std::vector<const ObjectState*> in_view;
    for (const ObjectState& state : track.states)
      if (state.status == ObjectStatus::active && frames.contains(state.frame)) in_view.push_back(&state);
    CarvedBody body{track.id, {body_of(track.states.front()), noise_per_range, options}, {}};
    for (const auto i : even_choice(std::ssize(in_view), options.views)) {
      const ObjectState& state = *in_view[static_cast<std::size_t>(i)];
      body.world_from_object[state.frame] = state.ellipsoid.world_from_object;
    }
    bodies.push_back(std::move(body));
  }
  return bodies;
}

}  // namespace

std::map<int, SurfaceFile> carve_bodies(const Sequence& sequence, const Perception& perception,
                                        const BackendResult& result, const Variant& variant) {
  const CarvingOptions& options = variant.body.carving;
  if (!options.enabled || !result.final || variant.perception.depth == DepthSource::lidar) return {};
  std::map<std::int64_t, const FrameInfo*> frames;
  for (const FrameInfo& info : perception.frames())
    if (info.final_camera && !info.depth_refused) frames[info.frame] = &info;
  std::vector<CarvedBody> bodies = bodies_to_carve(*result.final, frames, kNoisePerRange, options);
  for (const SequenceFrame& images : sequence.frames) {
    const auto sees = [&](const CarvedBody& body) { return body.world_from_object.contains(images.frame); };
    if (images.depth.empty() || std::ranges::none_of(bodies, sees)) continue;
    const cv::Mat depth_m = read_depth(sequence, images);
    const Pose camera_from_world = frames.at(images.frame)->final_camera->inverse();
    tbb::parallel_for(std::size_t{0}, bodies.size(), [&](std::size_t i) {
      CarvedBody& body = bodies[i];
      if (sees(body))
        body.carving.add(depth_m, sequence.camera,
                         camera_from_world * body.world_from_object.at(images.frame));
    });
  }
  std::map<int, SurfaceFile> carved;
  for (const CarvedBody& body : bodies) {
    const auto seen = result.surfaces.find(body.id);
    if (auto mesh = body.carving.carved(seen == result.surfaces.end() ? SurfaceFile{} : seen->second))
      carved[body.id] = std::move(*mesh);
  }
  return carved;
}

}  // namespace uniquadric
