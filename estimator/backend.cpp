#include "estimator/backend.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <map>
#include <set>
#include <span>

#include "estimator/factors/pose_jacobian.h"
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

// A state's pose of the object, whose place in the body is known by now.
PoseSample sample_of(const BodyState& state, const Pose& body_from_object) {
  const Matrix6d moved = adjoint(body_from_object.inverse());
  return {state.stamp_ns, state.world_from_body * body_from_object,
          moved * state.covariance * moved.transpose(), state.evidence};
}

// The states of a body's life as they are known at the end: the last shape, the whole trajectory smoothed,
// about which `look_again` looks at states that were guessed. From here on the body's frame is the object's.
template <typename LookAgain>
void finish_life(std::span<BodyState> states, const TrajectorySmootherOptions& options,
                 const LookAgain& look_again) {
  const Shape shape = states.back().shape;
  const auto smoothed = [&] {
    std::vector<PoseSample> samples;
    for (const BodyState& state : states) samples.push_back(sample_of(state, shape.body_from_object));
    smooth_trajectory(samples, options);
    return samples;
  };
  std::vector<PoseSample> samples = smoothed();
  const auto is_guess = [](const BodyState& state) { return state.evidence == PoseEvidence::guess; };
  if (std::any_of(states.begin(), states.end(), is_guess)) {
    const Pose object_from_body = shape.body_from_object.inverse();
    for (std::size_t i = 0; i < states.size(); ++i)
      if (is_guess(states[i])) look_again(states[i], samples[i].world_from_object * object_from_body);
    samples = smoothed();
  }
  for (std::size_t i = 0; i < states.size(); ++i) {
    states[i].shape = shape;
    states[i].shape.body_from_object = Pose();
    states[i].world_from_body = samples[i].world_from_object;
    states[i].covariance = samples[i].covariance;
  }
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
    if (body) seen_.insert(frame.frame);
    without_state_ += body && (!state || state->status == ObjectStatus::lost);
    if (state) states_.push_back(std::move(*state));
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
    if (states_.empty()) return;
    Stopwatch watch(states_.back().frame, times_);
    if (estimator_.is_present(states_.back()))
      surface_ = surface_file(estimator_.surface(), states_.back().shape.body_from_object.inverse());
    if (variant.output == Output::final) {
      forget_glimpses();
      finish_lives(variant.body.trajectory);
    }
    watch.stop("finish");
  }

  void give(BackendResult& result) const {
    result.observations_without_state += without_state_;
    result.times.insert(result.times.end(), times_.begin(), times_.end());
    if (states_.empty()) return;
    if (!surface_.points.empty()) result.surfaces[id_] = surface_;
    ObjectTrack& track = result.objects.emplace_back();
    track.id = id_;
    for (const BodyState& state : states_) track.states.push_back(object_state(state));
  }

 private:
  // A body is begun anew where its first sights led nowhere. What they were taken for is not what it turned
  // out to be, and nothing leads from their frame to that of the later life.
  void forget_glimpses() {
    std::set<int> lives = {states_.back().beginning};
    for (const BodyState& state : states_)
      if (state.status == ObjectStatus::active) lives.insert(state.beginning);
    std::erase_if(states_, [&](const BodyState& state) {
      const bool goes = !lives.contains(state.beginning);
      without_state_ += goes && state.status != ObjectStatus::lost && seen_.contains(state.frame);
      return goes;
    });
  }

  // Each life has a frame of its own.
  void finish_lives(const TrajectorySmootherOptions& options) {
    for (auto begin = states_.begin(); begin != states_.end();) {
      const auto end = std::find_if(
          begin, states_.end(), [&](const BodyState& state) { return state.beginning != begin->beginning; });
      finish_life({begin, end}, options,
                  [&](BodyState& state, const Pose& expected) { look_again(state, expected); });
      begin = end;
    }
  }

  void look_again(BodyState& state, const Pose& expected) const {
    const auto& frames = perception_.frames();
    const auto at =
        std::lower_bound(frames.begin(), frames.end(), state.frame,
                         [](const FrameInfo& info, std::int64_t frame) { return info.frame < frame; });
    const PerceivedFrame frame = perception_.read(static_cast<std::size_t>(at - frames.begin()));
    if (const BodyObservation* body = find_body(frame, id_))
      estimator_.look_again(frame, *body, expected, state);
  }

  int id_;
  const Perception& perception_;
  BodyEstimator estimator_;
  std::vector<BodyState> states_;
  std::set<std::int64_t> seen_;  // frames that show it
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
  for (const auto& [id, body] : by_id) body.give(result);
  return result;
}

}  // namespace uniquadric
