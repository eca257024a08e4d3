// What is written of a body once all of it is known.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>

#include "estimator/backend.h"
#include "estimator/objects/known_states.h"
#include "synthetic_perception.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr int kGlimpse = 5;  // frames
const Eigen::Vector3d kAxes(0.3, 0.2, 0.15);

Pose moving(double t) {
  return {exp_so3({0.2 * t, 0.1, 0.5 * t}), Eigen::Vector3d(-0.3 + 0.2 * t, 0.1 * t, 2)};
}

// `error`: by which the camera's poses are off at their frames, world_from_wrong_world of a time [s].
BackendResult result_of(
    const SyntheticPerception& perception,
    const std::function<Pose(double)>& error = [](double) { return Pose(); }) {
  const TempFolder temp;
  PerceptionWriter out(temp.path(), perception.camera, {});
  CameraTrajectories camera;
  for (const PerceivedFrame& frame : perception.frames) {
    out.add(frame);
    const Pose wrong = error(1e-9 * static_cast<double>(frame.stamp_ns)).inverse() * *frame.world_from_camera;
    camera.causal.push_back({frame.stamp_ns, wrong});
    camera.fixed_lag.push_back({frame.stamp_ns, *frame.world_from_camera});
  }
  camera.final = camera.fixed_lag;
  out.finish(camera);
  Variant variant;
  variant.backend = Backend::windows;
  return estimate_windows(Perception(temp.path()), variant, 1);
}

// The body comes into the image: some points of an edge of it, none of which is found again, are taken for a
// small body, which is begun anew. At the end that first one is known to have been none.
TEST(FinalStates, FirstSightsThatLedNowhereAreNoStates) {
  SyntheticOptions options;
  options.world_from_camera = [](double) { return Pose(); };
  const std::vector<SyntheticBody> bodies = {box_body(kAxes, moving)};
  SyntheticPerception perception = synthetic_perception(bodies, options);
  const Tracks truth = synthetic_truth(bodies, options);
  for (int n = 0; n < kGlimpse; ++n) {
    BodyObservation& glimpse = perception.frames[n].bodies.at(0);
    glimpse.points = glimpse.points.leftCols(20).eval();
    glimpse.normals = glimpse.normals.leftCols(20).eval();
    glimpse.colors.resize(3, 0);
    for (Feature& feature : glimpse.features) feature.track += 1'000'000 * (n + 1);
    if (n > 0) glimpse.motion.reset();
  }
  const BackendResult result = result_of(perception);
  ASSERT_TRUE(result.causal.size() == 1 && result.fixed_lag->size() == 1 && result.final->size() == 1);
  const auto &at_its_frame = result.causal[0].states, &at_the_end = result.final->at(0).states;
  EXPECT_EQ(std::ssize(at_its_frame) + result.observations_without_state, std::ssize(perception.frames));
  EXPECT_EQ(result.fixed_lag->at(0).states.size(), at_the_end.size());  // known within the lag
  EXPECT_LT(at_its_frame[0].frame, kGlimpse);                           // what was thought at the time
  ASSERT_GE(std::ssize(at_the_end), std::ssize(perception.frames) - kGlimpse - 1);
  for (const ObjectState& state : at_the_end) {
    const Ellipsoid& expected = truth.objects[0].states[state.frame].ellipsoid;
    EXPECT_LT((state.ellipsoid.world_from_object.translation - expected.world_from_object.translation).norm(),
              0.02)
        << state.frame;
    EXPECT_EQ(state.ellipsoid.semi_axes_m, at_the_end.back().ellipsoid.semi_axes_m) << state.frame;
  }
}

double worst_error_m(const std::vector<ObjectTrack>& objects, const Tracks& truth) {
  double worst_m = 0;
  for (const ObjectState& state : objects.at(0).states) {
    const Pose& expected = truth.objects[0].states[state.frame].ellipsoid.world_from_object;
    worst_m =
        std::max(worst_m, (state.ellipsoid.world_from_object.translation - expected.translation).norm());
  }
  return worst_m;
}

// The camera drifts by 5 cm/s, and later its poses are known: the body was always where the camera saw it.
TEST(FinalStates, StandWhereTheCameraIsKnownToHaveSeenThem) {
  SyntheticOptions options;
  options.world_from_camera = [](double) { return Pose(); };
  const std::vector<SyntheticBody> bodies = {box_body(kAxes, moving)};
  const Tracks truth = synthetic_truth(bodies, options);
  const BackendResult result = result_of(synthetic_perception(bodies, options), [](double t) {
    return Pose{exp_so3({0, 0.01 * t, 0}), Eigen::Vector3d(0.05 * t, 0, 0)};
  });
  const double last_s = 1e-9 * static_cast<double>(truth.objects[0].states.back().stamp_ns);
  EXPECT_GT(worst_error_m(result.causal, truth), 0.8 * 0.05 * last_s);
  EXPECT_LT(worst_error_m(*result.fixed_lag, truth), 0.02);
  EXPECT_LT(worst_error_m(*result.final, truth), 0.01);
}

// By then its whole surface is known, in the frame of its last life.
TEST(FinalStates, AGuessedPoseIsFoundByAnotherLook) {
  SyntheticOptions options;
  options.world_from_camera = [](double) { return Pose(); };
  const std::vector<SyntheticBody> bodies = {box_body(kAxes, moving)};
  const SyntheticPerception perception = synthetic_perception(bodies, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::vector<BodyState> states;
  for (const PerceivedFrame& frame : perception.frames)
    if (auto state = estimator.step(frame, &frame.bodies.at(0))) states.push_back(*state);
  const Pose object_from_body = states.back().shape.body_from_object.inverse();
  BodyState guess = states[states.size() / 2];
  const PerceivedFrame& frame = perception.frames[guess.frame];
  const Pose truth =
      synthetic_truth(bodies, options).objects[0].states[guess.frame].ellipsoid.world_from_object;
  guess.world_from_body = truth * Pose{exp_so3({0.05, -0.05, 0.05}), {0.02, -0.02, 0.02}} * object_from_body;
  const auto error_m = [&](const BodyState& state) {
    return ((state.world_from_body * object_from_body.inverse()).translation - truth.translation).norm();
  };
  BodyState earlier = guess;
  earlier.beginning -= 1;
  estimator.look_again(frame, frame.bodies[0], guess.world_from_body, earlier);
  EXPECT_EQ(earlier.world_from_body.translation, guess.world_from_body.translation);
  EXPECT_GT(error_m(guess), 0.03);
  estimator.look_again(frame, frame.bodies[0], guess.world_from_body, guess);
  EXPECT_LT(error_m(guess), 0.005);
}

// Each point, carried by the estimated pose and back by the true one, is on a side of the box.
TEST(FinalStates, PointsThatAreKeptLieOnTheBodyInItsOwnFrame) {
  SyntheticOptions options;
  options.world_from_camera = [](double) { return Pose(); };
  const std::vector<SyntheticBody> bodies = {box_body(kAxes, moving)};
  const SyntheticPerception perception = synthetic_perception(bodies, options);
  const Tracks truth = synthetic_truth(bodies, options);
  const BackendResult result = result_of(perception);
  for (const auto& objects : {result.causal, *result.final}) {
    ASSERT_TRUE(objects.size() == 1 && result.surfaces.size() == 1);
    const SurfaceFile& surface = result.surfaces.at(objects[0].id);
    ASSERT_EQ(surface.points.size(), surface.normals.size());
    EXPECT_GT(surface.points.size(), 100u);
    EXPECT_LT(surface.points.size(), 5000u);
    const ObjectState& state = objects[0].states.back();
    const Pose truth_from_object =
        truth.objects[0].states[state.frame].ellipsoid.world_from_object.inverse() *
        state.ellipsoid.world_from_object;
    int near = 0, outwards = 0;
    for (std::size_t i = 0; i < surface.points.size(); ++i) {
      const Eigen::Vector3d p = truth_from_object * surface.points[i].cast<double>();
      near += (p.cwiseAbs() - kAxes).cwiseAbs().minCoeff() < 0.01;
      outwards += p.dot(truth_from_object.rotation * surface.normals[i].cast<double>()) > 0;
    }
    const auto count = static_cast<double>(surface.points.size());
    EXPECT_GT(near, 0.95 * count);
    EXPECT_GT(outwards, 0.99 * count);
  }
}

}  // namespace
}  // namespace uniquadric
