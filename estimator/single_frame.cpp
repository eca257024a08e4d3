#include "estimator/single_frame.h"

#include <tbb/parallel_for.h>

#include <map>

#include "core/base/quantile.h"
#include "core/geometry/box_symmetry.h"
#include "estimator/window/trajectory_smoother.h"

namespace uniquadric {
namespace {

constexpr double kPoseVariance =
    1e-4;  // ours, of a box's pose [rad^2]; the smoother finds by how much it is off

ObjectState state_of(const PerceivedFrame& frame, const ObbEstimate& obb) {
  ObjectState state;
  state.frame = frame.frame;
  state.stamp_ns = frame.stamp_ns;
  state.ellipsoid = inscribed_ellipsoid(obb.box);
  state.ellipsoid.world_from_object = *frame.world_from_camera * state.ellipsoid.world_from_object;
  state.ellipsoid.world_from_object.rotation.normalize();
  if (obb.semi_axes_std_m.minCoeff() > 0)  // of one accepted box there is none
    state.covariance_diagonal.head<3>() = obb.semi_axes_std_m.cwiseAbs2();
  return state;
}

// States of one frame, their axes named as the world's.
struct FrameStates {
  std::map<int, ObjectState> states;  // by id
  int without_state = 0;
  std::vector<StageTime> times;
};

FrameStates estimate_frame(const PerceivedFrame& frame, const Variant& variant, std::uint64_t seed) {
  FrameStates result;
  if (!frame.world_from_camera) return result;
  Stopwatch watch(frame.frame, result.times);
  const Eigen::Matrix3d world_axes_in_camera =
      frame.world_from_camera->rotation.toRotationMatrix().transpose();
  for (const BodyObservation& body : frame.bodies) {
    RandomStream random(seed, "obb_ransac", frame.frame, body.id);
    const auto obb = fit_obb_ransac(body.points, variant.body.shape.obb, world_axes_in_camera, random);
    if (obb)
      result.states.emplace(body.id, state_of(frame, *obb));
    else
      ++result.without_state;
  }
  watch.stop("shape");
  return result;
}

// Renames the axes of a track's states, each to be nearest to the one before.
void follow_axes(ObjectTrack& track) {
  for (std::size_t i = 1; i < track.states.size(); ++i) {
    const auto axes = [&](std::size_t k) {
      return track.states[k].ellipsoid.world_from_object.rotation.toRotationMatrix();
    };
    ObjectState& state = track.states[i];
    const Eigen::Matrix3d P = nearest_box_rotation(axes(i), axes(i - 1));
    state.ellipsoid = relabel_axes(state.ellipsoid, P);
    state.covariance_diagonal.head<3>() =
        (P.cwiseAbs().transpose() * state.covariance_diagonal.head<3>()).eval();
  }
}

// One size for the whole track, and its trajectory smoothed as that of the windows is: all frames count
// alike.
void smooth(ObjectTrack& track, const TrajectorySmootherOptions& options) {
  std::vector<PoseSample> samples;
  Eigen::Vector3d semi_axes_m;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> lengths_m;
    for (const ObjectState& state : track.states) lengths_m.push_back(state.ellipsoid.semi_axes_m[axis]);
    semi_axes_m[axis] = upper_median(std::move(lengths_m));
  }
  Matrix6d covariance = Matrix6d::Identity();
  covariance.topLeftCorner<3, 3>() *= semi_axes_m.squaredNorm();  // a radian turns a box's corner by its size
  for (const ObjectState& state : track.states)
    samples.push_back({state.stamp_ns, state.ellipsoid.world_from_object, kPoseVariance * covariance});
  smooth_trajectory(samples, options);
  for (std::size_t i = 0; i < track.states.size(); ++i)
    track.states[i].ellipsoid = {samples[i].world_from_object, semi_axes_m};
}

}  // namespace

BackendResult estimate_single_frames(const Perception& perception, const Variant& variant,
                                     std::uint64_t seed) {
  std::vector<FrameStates> frames(perception.frames().size());
  tbb::parallel_for(std::size_t{0}, frames.size(),
                    [&](std::size_t i) { frames[i] = estimate_frame(perception.read(i), variant, seed); });
  BackendResult result;
  if (variant.smooth) result.final.emplace();
  std::map<int, ObjectTrack> tracks;
  for (const FrameStates& frame : frames) {
    for (const auto& [id, state] : frame.states) tracks[id].states.push_back(state);
    result.observations_without_state += frame.without_state;
    result.times.insert(result.times.end(), frame.times.begin(), frame.times.end());
  }
  for (auto& [id, track] : tracks) {
    track.id = id;
    if (variant.axis_naming == AxisNaming::previous) follow_axes(track);
    result.causal.push_back(track);
    if (!variant.smooth) continue;
    smooth(track, variant.body.trajectory);
    result.final->push_back(std::move(track));
  }
  return result;
}

}  // namespace uniquadric
