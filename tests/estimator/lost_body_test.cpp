// Bodies that are hidden or not recognised: where they are meanwhile, and how they are found again.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "body_run.h"

namespace uniquadric {
namespace {

// What is in its mask later is no more its surface: it stays where that is seen, and is not carried on.
TEST(BodyEstimator, ABodyThatIsNotRecognisedStaysWhereItsMaskIs) {
  const auto place = [](double t) { return Eigen::Vector3d(-0.4 + 0.5 * std::min(t, 1.2), 0, 1); };
  const auto moving = [&](double t) { return Pose{Eigen::Quaterniond::Identity(), place(t)}; };
  SyntheticOptions options = three_seconds();
  options.world_from_camera = [](double) { return looking_at({0, -2.2, 1.4}, {0, 0, 1}); };
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, moving)}, options);
  const SyntheticPerception other =
      synthetic_perception({ellipsoid_body({0.12, 0.3, 0.12}, moving)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<BodyState> state;
  for (std::size_t i = 0; i < perception.frames.size(); ++i) {
    BodyObservation& body = perception.frames[i].bodies[0];
    if (i > 36) {
      body = other.frames[i].bodies[0];
      body.features.clear();
    }
    state = estimator.step(perception.frames[i], &body);
  }
  ASSERT_TRUE(state);
  const Pose object = state->world_from_body * state->shape.body_from_object;
  EXPECT_LT((object.translation - place(3)).norm(), 0.2) << to_string(state->status);
}

// Depth under the mask of a body that was lost is that of what is behind it: under a whole outline, as of
// needles, and under the part that its occluder leaves.
TEST(BodyEstimator, ABodyIsNotLookedForBehindItself) {
  const auto still = [](double) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, 1}}; };
  for (const bool whole : {true, false}) {
    SyntheticPerception perception = synthetic_perception({box_body(kAxes, still)}, three_seconds());
    BodyEstimator estimator(1, perception.camera, {}, 1);
    std::optional<BodyState> state;
    for (std::size_t i = 0; i < 70; ++i) {
      BodyObservation& body = perception.frames[i].bodies[0];
      if (i > 40) {
        body.features.clear();
        body.points *= 2.5;
        body.silhouette->support[0].free = whole;
        if (!whole) body.silhouette->rot_bbox.semi_major /= 2;
      }
      state = estimator.step(perception.frames[i], &body);
    }
    ASSERT_TRUE(state);
    EXPECT_EQ(state->status, ObjectStatus::occluded);
    const Pose object = state->world_from_body * state->shape.body_from_object;
    EXPECT_LT((object.translation - still(0).translation).norm(), 0.05) << whole;
  }
}

// For one frame its mask lies on its twin, further away than any impact throws it.
TEST(BodyEstimator, AMaskOnAnotherBodyDoesNotMoveIt) {
  const auto at = [](double x) {
    return [x](double) { return Pose{Eigen::Quaterniond::Identity(), {x, 0, 1}}; };
  };
  static constexpr int kWrong = 30;
  SyntheticOptions options = three_seconds();
  options.frames = kWrong + 2;
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, at(0))}, options);
  const SyntheticPerception twin = synthetic_perception({box_body(kAxes, at(1.5))}, options);
  for (const bool weighs : {true, false}) {
    BodyOptions body_options;
    body_options.lifecycle.weighs_evidence = weighs;
    BodyEstimator estimator(1, perception.camera, body_options, 1);
    for (std::size_t i = 0; i < perception.frames.size(); ++i) {
      BodyObservation body = (i == kWrong ? twin : perception).frames[i].bodies[0];
      if (i == kWrong) body.features.clear(), body.motion.reset();
      const auto state = estimator.step(perception.frames[i], &body);
      if (i < kWrong) continue;
      ASSERT_TRUE(state);
      const Pose object = state->world_from_body * state->shape.body_from_object;
      const double off_m = (object.translation - Eigen::Vector3d(0, 0, 1)).norm();
      if (!weighs && i > kWrong) continue;  // its own mask again: anywhere
      EXPECT_EQ(off_m < 0.03, weighs) << i << ": " << off_m;
    }
  }
}

// The mask of its first frames was another's: what was learnt of them fits in no later one.
TEST(BodyEstimator, ABodyWhoseModelIsWrongIsBegunAnew) {
  const auto still = [](double) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, 1}}; };
  const SyntheticOptions options = three_seconds();
  const SyntheticPerception box = synthetic_perception({box_body(kAxes, still)}, options),
                            other = synthetic_perception({ellipsoid_body({0.05, 0.6, 0.05}, still)}, options);
  for (const bool drops : {true, false}) {
    BodyOptions body_options;
    body_options.lifecycle.drops_models = drops;
    BodyEstimator estimator(1, box.camera, body_options, 1);
    std::optional<BodyState> state;
    for (std::size_t i = 0; i < box.frames.size(); ++i) {
      BodyObservation body = (i < 25 ? other : box).frames[i].bodies[0];
      for (Feature& feature : body.features) feature.track += i < 25 ? 100'000 : 0;
      state = estimator.step(box.frames[i], &body);
    }
    ASSERT_TRUE(state);
    const Eigen::Vector3d off_m = by_size(state->shape.semi_axes_m) - by_size(kAxes);
    EXPECT_EQ(state->beginning, drops ? 1 : 0);
    EXPECT_EQ(off_m.cwiseAbs().maxCoeff() < 0.02, drops) << off_m.transpose();
  }
}

// It shows the same faces before and after, and none of its features is known any more.
TEST(BodyEstimator, ABodyThatWasHiddenIsFoundAgainByItsSurface) {
  const auto swaying = [](double t) {
    return Pose{exp_so3({0.1 * std::sin(t), 0.1 * std::cos(t), 0.5 + 0.25 * std::sin(1.5 * t)}),
                {0.1 * std::sin(t), 0, 1}};
  };
  SyntheticOptions options = three_seconds();
  options.frames = 120;
  options.found_again = false;
  options.hidden = [](int, double t) { return t > 1.5 && t < 2.5; };
  const Errors after = largest_errors(box_body(kAxes, swaying), options, 2.6);
  EXPECT_EQ(after.frames, 42);
  EXPECT_LT(after.translation_m, 0.01);
  EXPECT_LT(after.rotation_rad, 0.03);
  EXPECT_LT(after.axes_m, 0.006);
}

// It shows other faces than when it was last seen, and goes on turning.
TEST(BodyEstimator, ATumblingBodyThatWasHiddenIsFoundAgainByItsSurface) {
  for (const double until : {1.8, 2.5}) {
    SyntheticOptions options = three_seconds();
    options.frames = 120;
    options.found_again = false;
    options.hidden = [until](int, double t) { return t > 1.5 && t < until; };
    const Errors after = largest_errors(box_body(kAxes, tumbling), options, 3);
    EXPECT_EQ(after.frames, 30);
    EXPECT_LT(after.translation_m, 0.01) << until;
    EXPECT_LT(after.axes_m, 0.005) << until;
    // without colours nothing tells the box from itself turned by half
    EXPECT_LT(std::min(after.rotation_rad, std::abs(after.rotation_rad - std::numbers::pi)), 0.03) << until;
  }
}

TEST(BodyEstimator, ABodyThatWasHiddenIsFoundAgainByItsFeatures) {
  SyntheticOptions options = three_seconds();
  options.frames = 120;
  options.hidden = [](int, double t) { return t > 1.5 && t < 2.5; };
  const Errors after = largest_errors(box_body(kAxes, tumbling), options, 2.6);
  EXPECT_EQ(after.frames, 42);
  EXPECT_LT(after.translation_m, 0.01);
  EXPECT_LT(after.rotation_rad, 0.03);
}

// Half a second of prediction, then once that it is lost, then nothing; when it is found again, it goes on.
TEST(BodyEstimator, ABodyThatStaysHiddenIsSaidToBeLostOnce) {
  SyntheticOptions options = three_seconds();
  options.frames = 120;
  options.hidden = [](int, double t) { return t > 1.5 && t < 2.5; };
  const SyntheticPerception perception = synthetic_perception({box_body(kAxes, tumbling)}, options);
  BodyOptions body;
  body.lifecycle.lost_after_s = 0.5;
  body.lifecycle.ends_unplaced = false;
  BodyEstimator estimator(1, perception.camera, body, 1);
  int predicted = 0, lost = 0, silent = 0, last_predicted = 0;
  for (int i = 0; i < std::ssize(perception.frames); ++i) {
    const auto& bodies = perception.frames[i].bodies;
    const auto state = estimator.step(perception.frames[i], bodies.empty() ? nullptr : &bodies[0]);
    silent += !state;
    if (!state) continue;
    if (bodies.empty() && state->status == ObjectStatus::occluded) ++predicted, last_predicted = i;
    if (state->status != ObjectStatus::lost) continue;
    EXPECT_EQ(i, last_predicted + 1);
    EXPECT_EQ(state->evidence, PoseEvidence::none);
    ++lost;
  }
  EXPECT_EQ(predicted, 15);
  EXPECT_EQ(lost, 1);
  EXPECT_GT(silent, 10);
  EXPECT_EQ(estimator.step(perception.frames.back(), &perception.frames.back().bodies.at(0))->status,
            ObjectStatus::active);
}

// Frames after 1.5 s with a prediction of a body that is hidden from then on.
int predicted_frames(const std::function<Pose(double)>& world_from_body, const BodyOptions& body) {
  SyntheticOptions options = three_seconds();
  options.hidden = [](int, double t) { return t > 1.5; };
  const SyntheticPerception perception = synthetic_perception({box_body(kAxes, world_from_body)}, options);
  BodyEstimator estimator(1, perception.camera, body, 1);
  int predicted = 0;
  for (const PerceivedFrame& frame : perception.frames) {
    const auto state = estimator.step(frame, frame.bodies.empty() ? nullptr : &frame.bodies[0]);
    predicted += state && state->status == ObjectStatus::occluded;
  }
  return predicted;
}

// The sigma of the prediction, a t^2 / 2 and that over one frame, exceeds the longest semi-axis.
TEST(BodyEstimator, APredictionLessSureThanTheBodyIsLargeIsGivenUp) {
  BodyOptions body;
  const double longest_m = kAxes.maxCoeff(), of_a_frame_m = 0.02;
  const double until_s = std::sqrt(2 * (longest_m - of_a_frame_m) / body.lifecycle.acceleration_mps2);
  EXPECT_NEAR(predicted_frames(tumbling, body), 30 * until_s, 1.5);
  body.lifecycle.ends_unplaced = false;
  EXPECT_GE(predicted_frames(tumbling, body), 43);
}

TEST(BodyEstimator, ABodyAtRestIsPredictedWhereItIs) {
  const Pose resting{Eigen::Quaterniond::Identity(), {0, 0, 1}};
  EXPECT_GE(predicted_frames([&](double) { return resting; }, BodyOptions()), 43);
}

// It leaves the image at 2 m/s, and is where nobody sees it: its prediction ends there, not seconds later.
TEST(BodyEstimator, ABodyThatLeavesTheImageIsLostThere) {
  const auto passing = [](double t) {
    return Pose{Eigen::Quaterniond::Identity(), {std::max(0.0, 2 * (t - 1)), 0, 1}};
  };
  SyntheticOptions options = three_seconds();
  options.world_from_camera = [](double) { return looking_at({0, -2.2, 1.4}, {0, 0, 1}); };
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, passing)}, options);
  for (const bool ends_outside : {true, false}) {
    BodyOptions body;
    body.lifecycle.ends_outside = ends_outside;
    body.lifecycle.ends_unplaced = false;
    BodyEstimator estimator(1, perception.camera, body, 1);
    int outside = 0, lost = 0;
    for (std::size_t i = 0; i < perception.frames.size(); ++i) {
      const PerceivedFrame& frame = perception.frames[i];
      const Eigen::Vector3d middle =
          frame.world_from_camera->inverse() * passing(static_cast<double>(i) / 30).translation;
      const bool is_outside =
          !perception.camera.contains((perception.camera.matrix() * middle).hnormalized());
      const auto state = estimator.step(frame, is_outside ? nullptr : &frame.bodies.at(0));
      outside += is_outside && state;
      lost += state && state->status == ObjectStatus::lost;
    }
    EXPECT_EQ(lost, ends_outside ? 1 : 0);
    if (ends_outside)
      EXPECT_LE(outside, 9);
    else
      EXPECT_GT(outside, 15);
  }
}

}  // namespace
}  // namespace uniquadric
