#include "estimator/backend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>

#include "core/base/seconds.h"
#include "estimator/factors/pose_jacobian.h"
#include "estimator/objects/known_states.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

// Frames in memory at once: bodies go through them beside each other, and wait for each other at their end.
constexpr std::size_t kBatch = 32;

const BodyObservation* find_body(const PerceivedFrame& frame, int id) {
  for (const BodyObservation& body : frame.bodies)
    if (body.id == id) return &body;
  return nullptr;
}

// The pose's, moved from the body's frame to the object's, and those of the shape's place in the body: first
// order, along the object's axes.
Vector9d variances_of(const BodyState& body) {
  const Matrix6d moved = adjoint(body.shape.body_from_object.inverse());
  Vector9d variances = body.shape.variances;
  variances.tail<6>() += (moved * body.covariance * moved.transpose()).diagonal();
  return variances;
}

ObjectState object_state(const BodyState& body) {
  ObjectState state;
  state.frame = body.frame;
  state.stamp_ns = body.stamp_ns;
  state.ellipsoid = {body.world_from_body * body.shape.body_from_object, body.shape.semi_axes_m};
  state.ellipsoid.world_from_object.rotation.normalize();
  state.exponents = body.shape.exponents;
  state.profile_axis = body.shape.profile_axis;
  state.covariance_diagonal = variances_of(body);
  state.status = body.status;
  state.motion = body.motion;
  return state;
}

// Evenly thinned: a bound for what is written.
SurfaceFile surface_file(const SurfaceModel& model, const Pose& object_from_body) {
  constexpr std::ptrdiff_t kMostPoints = 20'000;  // 0.5 MB; bodies have some thousands
  SurfaceFile file;
  for (const auto i : even_choice(model.points.cols(), kMostPoints)) {
    file.points.push_back((object_from_body * model.points.col(i)).cast<float>());
    file.normals.push_back((object_from_body.rotation * model.normals.col(i)).cast<float>());
  }
  return file;
}

// One body through the frames, in their order.
class BodyRun {
 public:
  BodyRun(int id, const Perception& perception, const Variant& variant, std::uint64_t seed)
      : id_(id), perception_(perception), estimator_(id, perception.camera(), variant.body, seed) {}

  void step(const PerceivedFrame& frame) {
    std::vector<StageTime> windows, solutions;
    Stopwatch watch(frame.frame, windows);
    const BodyObservation* body = find_body(frame, id_);
    auto state = estimator_.step(frame, body, &solutions);
    without_state_ += body && (!state || state->status == ObjectStatus::lost);
    if (state) raw_.push_back({std::move(*state), frame});
    watch.stop("windows");
    for (StageTime& solution : solutions) {
      solution.frame = frame.frame;
      windows.back().ms -= solution.ms;  // stages do not overlap
    }
    times_.insert(times_.end(), solutions.begin(), solutions.end());
    times_.push_back(windows.back());
  }

  // After its last frame.
  void finish(const Variant& variant) {
    if (raw_.empty()) return;
    const BodyState& last = raw_.back().state;
    Stopwatch watch(last.frame, times_);
    if (estimator_.is_present(last))
      surface_ = surface_file(estimator_.surface(), last.shape.body_from_object.inverse());
    const TrajectorySmootherOptions& options = variant.body.trajectory;
    final_ = final_states(raw_, options,
                          [&](BodyState& state, const Pose& expected) { look_again(state, expected); });
    lagged_ = states_known_after(nanoseconds(variant.perception.fixed_lag_s), raw_, options);
    std::erase_if(raw_, [](const RawState& raw) { return raw.frame.camera_came_late; });
    causal_ = states_known_after(0, raw_, options);
    watch.stop("finish");
  }

  void give(BackendResult& result) const {
    result.observations_without_state += without_state_;
    result.times.insert(result.times.end(), times_.begin(), times_.end());
    if (!surface_.points.empty()) result.surfaces[id_] = surface_;
    add_track(causal_, result.causal);
    add_track(lagged_, *result.fixed_lag);
    add_track(final_, *result.final);
  }

 private:
  void add_track(const std::vector<BodyState>& states, std::vector<ObjectTrack>& tracks) const {
    if (states.empty()) return;
    ObjectTrack& track = tracks.emplace_back();
    track.id = id_;
    for (const BodyState& state : states) track.states.push_back(object_state(state));
  }

  void look_again(BodyState& state, const Pose& expected) const {
    const auto& frames = perception_.frames();
    const auto at =
        std::lower_bound(frames.begin(), frames.end(), state.frame,
                         [](const FrameInfo& info, std::int64_t frame) { return info.frame < frame; });
    PerceivedFrame frame = perception_.read(static_cast<std::size_t>(at - frames.begin()));
    frame.world_from_camera = frame.final_camera;
    if (const BodyObservation* body = find_body(frame, id_))
      estimator_.look_again(frame, *body, expected, state);
  }

  int id_;
  const Perception& perception_;
  BodyEstimator estimator_;
  std::vector<RawState> raw_;
  std::vector<BodyState> causal_, lagged_, final_;
  int without_state_ = 0;
  SurfaceFile surface_;
  std::vector<StageTime> times_;
};

}  // namespace

BackendResult estimate_windows(const Perception& perception, const Variant& variant, std::uint64_t seed) {
  std::map<int, BodyRun> by_id;
  const auto for_each_body = [&](const auto& f) {  // beside each other
    std::vector<BodyRun*> bodies;
    for (auto& [id, body] : by_id) bodies.push_back(&body);
    tbb::parallel_for(std::size_t{0}, bodies.size(), [&](std::size_t i) { f(*bodies[i]); });
  };
  for (std::size_t begin = 0, end; begin < perception.frames().size(); begin = end) {
    end = std::min(begin + kBatch, perception.frames().size());
    std::vector<PerceivedFrame> frames;
    for (std::size_t i = begin; i < end; ++i) frames.push_back(perception.read(i));
    for (const PerceivedFrame& frame : frames)
      for (const BodyObservation& body : frame.bodies)
        by_id.try_emplace(body.id, body.id, perception, variant, seed);
    for_each_body([&](BodyRun& body) {
      for (const PerceivedFrame& frame : frames) body.step(frame);
    });
  }
  for_each_body([&](BodyRun& body) { body.finish(variant); });
  BackendResult result;
  result.fixed_lag.emplace();
  result.final.emplace();
  for (const auto& [id, body] : by_id) body.give(result);
  return result;
}

}  // namespace uniquadric
