#include "estimator/objects/body_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "synthetic_perception.h"

namespace uniquadric {
namespace {

Pose looking_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at) {
  const Eigen::Vector3d z = (at - from).normalized(), x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return {Eigen::Quaterniond(R), from};
}

Pose arc_camera(double t) {
  const double angle = -0.6 + 0.1 * t;
  return looking_at({2.2 * std::sin(angle), -2.2 * std::cos(angle), 1.6}, {0, 0, 1});
}

Pose tumbling(double t) {
  const Eigen::Vector3d axis(0.3, 0.2, 1), wander(std::sin(t), std::cos(0.8 * t), 0.5 * std::sin(2 * t));
  return {exp_so3(0.6 * t * axis.normalized()), Eigen::Vector3d(0, 0, 1) + 0.2 * wander};
}

const Eigen::Vector3d kAxes(0.3, 0.2, 0.15);

struct Errors {
  double translation_m = 0, rotation_rad = 0, axes_m = 0;  // largest over the frames asked for
  int frames = 0;
};

// The axes' names are the estimator's choice.
Eigen::Vector3d by_size(Eigen::Vector3d axes) {
  std::sort(axes.begin(), axes.end());
  return axes;
}

Errors run(const SyntheticPerception& perception, const SyntheticBody& body, const SyntheticOptions& options,
           double from_s, const BodyOptions& body_options = {}) {
  const Tracks truth = synthetic_truth({body}, options);
  BodyEstimator estimator(1, perception.camera, body_options, 1);
  Errors errors;
  for (std::size_t i = 0; i < perception.frames.size(); ++i) {
    const auto& bodies = perception.frames[i].bodies;
    const auto state = estimator.step(perception.frames[i], bodies.empty() ? nullptr : &bodies[0]);
    if (!state || static_cast<double>(i) < from_s * options.rate_hz) continue;
    const Pose object = state->world_from_body * state->shape.body_from_object;
    const Ellipsoid& expected = truth.objects[0].states[i].ellipsoid;
    const auto raise = [](double& largest, double value) { largest = std::max(largest, value); };
    raise(errors.translation_m, (object.translation - expected.world_from_object.translation).norm());
    raise(errors.rotation_rad, object.rotation.angularDistance(expected.world_from_object.rotation));
    raise(errors.axes_m,
          (by_size(state->shape.semi_axes_m) - by_size(expected.semi_axes_m)).cwiseAbs().maxCoeff());
    ++errors.frames;
  }
  return errors;
}

Errors run(const SyntheticBody& body, const SyntheticOptions& options, double from_s,
           const BodyOptions& body_options = {}) {
  return run(synthetic_perception({body}, options), body, options, from_s, body_options);
}

SyntheticOptions three_seconds() {
  SyntheticOptions options;
  options.world_from_camera = arc_camera;
  return options;
}

TEST(BodyEstimator, FindsPoseAndSizeOfATumblingBoxWithinMillimetres) {
  const Errors errors = run(box_body(kAxes, tumbling), three_seconds(), 1.5);
  EXPECT_EQ(errors.frames, 45);
  EXPECT_LT(errors.translation_m, 0.008);
  EXPECT_LT(errors.rotation_rad, 0.03);
  EXPECT_LT(errors.axes_m, 0.006);
}

TEST(BodyEstimator, AndOfAnEllipsoid) {
  const Errors errors = run(ellipsoid_body(kAxes, tumbling), three_seconds(), 2.0);
  EXPECT_EQ(errors.frames, 30);
  EXPECT_LT(errors.translation_m, 0.008);
  EXPECT_LT(errors.rotation_rad, 0.05);  // its outline turns less than a box's
  EXPECT_LT(errors.axes_m, 0.006);
}

void put_under_one_mask(BodyObservation& body, const BodyObservation& other) {
  for (std::size_t k = 0; k < body.silhouette->support.size(); ++k)
    body.silhouette->support[k].offset_px =
        std::max(body.silhouette->support[k].offset_px, other.silhouette->support[k].offset_px);
  const Eigen::Index n = body.points.cols(), more = other.points.cols();
  for (Eigen::Matrix3Xd BodyObservation::*each : {&BodyObservation::points, &BodyObservation::normals}) {
    (body.*each).conservativeResize(3, n + more);
    (body.*each).rightCols(more) = other.*each;
  }
}

// A segmenter that takes two bodies for one, for half a second.
TEST(BodyEstimator, KeepsItsShapeWhileAnotherBodyIsUnderItsMask) {
  const SyntheticBody body = box_body(kAxes, tumbling), other = box_body(kAxes, [](double t) {
                                                          Pose beside = tumbling(t);
                                                          beside.translation.x() += 0.8;
                                                          return beside;
                                                        });
  SyntheticPerception perception = synthetic_perception({body, other}, three_seconds());
  for (std::size_t i = 40; i < 55; ++i)
    put_under_one_mask(perception.frames[i].bodies[0], perception.frames[i].bodies[1]);
  const Errors errors = run(perception, body, three_seconds(), 1.5);
  EXPECT_EQ(errors.frames, 45);
  EXPECT_LT(errors.translation_m, 0.008);
  EXPECT_LT(errors.axes_m, 0.006);
}

// One exponent makes it a box or an egg.
TEST(BodyEstimator, AndOfADisc) {
  const SyntheticBody disc = cylinder_body(0.25, 0.04, tumbling);
  EXPECT_LT(run(disc, three_seconds(), 2.0).axes_m, 0.006);
  BodyOptions one;
  one.shape.long_window.exponents = 1;
  EXPECT_GT(run(disc, three_seconds(), 2.0, one).axes_m, 0.006);
}

// Seen edge on at first: which axis the profile is along is found a second later, and the axes keep their
// names.
TEST(BodyEstimator, ADiscsAxesKeepTheirNames) {
  const auto opens = [](double t) {
    const double turned = std::max(0.0, 0.8 * (t - 1)), spun = 0.3 * t;
    return Pose{exp_so3({0, 0, turned}) * exp_so3({0, std::numbers::pi / 2, 0}) * exp_so3({0, 0, spun}),
                {0, 0, 1}};
  };
  SyntheticOptions options = three_seconds();
  options.world_from_camera = [](double) { return looking_at({0, -2.2, 1}, {0, 0, 1}); };
  const SyntheticPerception perception = synthetic_perception({cylinder_body(0.25, 0.04, opens)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<Pose> before;
  for (const PerceivedFrame& frame : perception.frames) {
    const auto state = estimator.step(frame, &frame.bodies[0]);
    if (before) {
      EXPECT_LT(before->rotation.angularDistance(state->shape.body_from_object.rotation), 1) << frame.frame;
    }
    before = state->shape.body_from_object;
  }
}

// Ten times as long as wide, and few features.
TEST(BodyEstimator, AndOfARod) {
  SyntheticOptions options = three_seconds();
  options.features = 3;
  const Errors errors = run(box_body({0.4, 0.03, 0.03}, tumbling), options, 2.0);
  EXPECT_LT(errors.translation_m, 0.01);
  EXPECT_LT(errors.axes_m, 0.01);
}

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

// Nothing tells how far a blank cylinder has turned: it stands still, and its turn is not known.
TEST(BodyEstimator, ABlankCylinderAtRestDoesNotMove) {
  SyntheticOptions options = three_seconds();
  const auto still = [](double) { return Pose{exp_so3({0.3, 0.2, 0}), {0, 0, 1}}; };
  SyntheticPerception perception = synthetic_perception({cylinder_body(0.2, 0.25, still)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<BodyState> state;
  for (std::size_t i = 0; i < perception.frames.size(); ++i) {
    BodyObservation& body = perception.frames[i].bodies[0];
    body.features.resize(6);
    for (std::size_t k = 0; k < 6; ++k) {  // along the outline, and so with the camera
      Feature& corner = body.features[k];
      const Pose camera_from_body = perception.frames[i].world_from_camera->inverse() * still(0);
      const Eigen::Vector3d view = camera_from_body.inverse().translation;
      const double angle = std::atan2(view.y(), view.x()) + (k % 2 ? 1.3 : -1.3);
      const Eigen::Vector3d p =
          camera_from_body * Eigen::Vector3d(0.2 * std::cos(angle), 0.2 * std::sin(angle),
                                             0.2 * (static_cast<double>(k / 2) - 1));
      corner.track = static_cast<std::int64_t>(k);
      corner.pixel = *perception.camera.project(p);
      corner.depth_m = p.z();
      corner.depth_sigma_m = 0.003;
      corner.rim = true;
    }
    state = estimator.step(perception.frames[i], &body);
  }
  ASSERT_TRUE(state);
  EXPECT_EQ(state->motion, ObjectMotion::at_rest);
  const Eigen::Matrix3d R = state->shape.body_from_object.rotation.toRotationMatrix();
  const Eigen::Vector3d axis = state->world_from_body.rotation.conjugate() * still(0).rotation *
                               Eigen::Vector3d::UnitZ(),
                        across = axis.unitOrthogonal();
  const Eigen::Matrix3d turn = state->covariance.bottomRightCorner<3, 3>();
  EXPECT_GT(std::sqrt(axis.dot(turn * axis)), 0.15);
  EXPECT_LT(std::sqrt(across.dot(turn * across)), 0.05);
  EXPECT_GT((R * state->shape.variances.tail<3>().cwiseSqrt().asDiagonal() * R.transpose() * axis).norm(),
            0.2);  // nor are its axes across
}

// Its axes come out a tenth to a half too long.
TEST(BodyEstimator, AnEllipsoidAboutABoxIsKnownToFitBadly) {
  const SyntheticPerception perception = synthetic_perception({box_body(kAxes, tumbling)}, three_seconds());
  const auto sigma_m = [&](int exponents) {
    BodyOptions options;
    options.shape.long_window.exponents = exponents;
    options.shape.long_window.extents = false;
    BodyEstimator estimator(1, perception.camera, options, 1);
    std::optional<BodyState> state;
    for (const PerceivedFrame& frame : perception.frames) state = estimator.step(frame, &frame.bodies[0]);
    return state->shape.variances.head<3>().cwiseSqrt().eval();
  };
  const Eigen::Vector3d fits = sigma_m(3), does_not = sigma_m(0);
  EXPECT_GT((does_not.cwiseQuotient(fits)).minCoeff(), 1.5);
}

// Seen from one side, no axis is known better than what nobody saw of it.
TEST(BodyEstimator, EndsThatNoCameraSawAreUncertain) {
  const auto facing = [](double) { return Pose{Eigen::Quaterniond::Identity(), {0, 0, 1}}; };
  SyntheticOptions options = three_seconds();
  options.world_from_camera = [](double) { return looking_at({0, -2.2, 1}, {0, 0, 1}); };
  const SyntheticPerception perception = synthetic_perception({box_body(kAxes, facing)}, options);
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<BodyState> state;
  for (const PerceivedFrame& frame : perception.frames) state = estimator.step(frame, &frame.bodies[0]);
  EXPECT_GT(state->shape.variances.head<3>().cwiseSqrt().minCoeff(), 0.02 * kAxes.minCoeff());
}

// configs/variants/rotbbox_rigid_axis.yaml
BodyOptions paper() {
  BodyOptions options;
  options.shape.obb.fit = BoxFit::tight_surface;
  LongWindowOptions& window = options.shape.long_window;
  window.semantic = SemanticFactor::vector;
  window.outline = Outline::rot_bbox;
  window.outline_noise = OutlineNoise::measured;
  window.exponents = 0;
  window.rigid_prior = RigidPrior::soft;
  window.axis_prior = AxisPrior::renyi;
  window.axis_samples = AxisSamples::extents;
  window.surface_points = window.extents = false;
  return options;
}

// A quadric fitted to a box's outlines alone is up to twice its size. It takes its time to find the axes.
TEST(BodyEstimator, ThePapersQuadricIsInscribedInABox) {
  const Errors errors = run(box_body(kAxes, tumbling), three_seconds(), 2.7, paper());
  EXPECT_EQ(errors.frames, 9);
  EXPECT_LT(errors.translation_m, 0.015);
  EXPECT_LT(errors.axes_m, 0.01);
}

// Of all rectangles about an ellipse the least stands along its axes, so that the ellipse in it is the
// outline itself: without noise in the outlines the ellipsoid is found exactly, but for the grid of a degree
// over which the rectangle is sought.
TEST(BodyEstimator, ThePapersQuadricIsTheEllipsoid) {
  SyntheticOptions options = three_seconds();
  options.outline_sigma_px = 0;
  const Errors errors = run(ellipsoid_body(kAxes, tumbling), options, 2.7, paper());
  EXPECT_EQ(errors.frames, 9);
  EXPECT_LT(errors.translation_m, 0.005);
  EXPECT_LT(errors.rotation_rad, 0.03);  // a degree and a half
  EXPECT_LT(errors.axes_m, 0.01);
}

// The least of many noisy rectangles is turned at random.
TEST(BodyEstimator, ThePapersQuadricIsAboutTheEllipsoidOfNoisyOutlines) {
  const Errors errors = run(ellipsoid_body(kAxes, tumbling), three_seconds(), 2.7, paper());
  EXPECT_EQ(errors.frames, 9);
  EXPECT_LT(errors.translation_m, 0.05);
  EXPECT_LT(errors.axes_m, 0.04);
}

// The segmenter's outlines of early frames come four frames late, and say that the body is a tenth larger.
// Nothing may be known of them before.
TEST(BodyEstimator, WhatComesLateIsNotKnownBefore) {
  constexpr int kLate = 4, kFirst = 20;
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, tumbling)}, three_seconds());
  std::vector<std::vector<Eigen::Vector3d>> axes;
  BodyOptions by_outlines;
  by_outlines.shape.long_window.extents = false;
  for (const bool has_late : {false, true}) {
    for (PerceivedFrame& frame : perception.frames) {
      BodyObservation& body = frame.bodies.at(0);
      if (!has_late || frame.frame < kFirst) continue;
      body.segmented = body.silhouette;
      body.segmented->known_at_frame = frame.frame + kLate;
      const Eigen::Vector2d& center = body.silhouette->rot_bbox.center;
      for (SupportLine& line : body.segmented->support)
        line.offset_px += 0.1 * (line.offset_px - line.normal.dot(center));
    }
    BodyEstimator estimator(1, perception.camera, by_outlines, 1);
    auto& states = axes.emplace_back();
    for (const PerceivedFrame& frame : perception.frames)
      states.push_back(estimator.step(frame, &frame.bodies[0])->shape.semi_axes_m);
  }
  const auto size = [&](bool late, std::size_t frame) { return axes[late][frame].sum(); };
  for (std::size_t n = 0; n < kFirst + kLate; ++n) EXPECT_EQ(axes[0][n], axes[1][n]) << n;
  EXPECT_GT(size(true, 89), 1.02 * size(false, 89));  // then they take the place of the earlier ones
}

TEST(BodyEstimator, WhatFillsTheImageIsNoBodyYet) {
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, tumbling)}, three_seconds());
  constexpr int kFilled = 5;
  for (int i = 0; i < kFilled; ++i)
    for (SupportLine& line : perception.frames[i].bodies.at(0).silhouette->support) line.free = false;
  BodyEstimator estimator(1, perception.camera, {}, 1);
  for (int i = 0; i <= kFilled; ++i)
    EXPECT_EQ(estimator.step(perception.frames[i], &perception.frames[i].bodies[0]).has_value(),
              i == kFilled);
}

// The first sight is a glimpse of some points, none of which is seen again: the next one is another first.
TEST(BodyEstimator, AGlimpseThatLeadsNowhereIsForgotten) {
  SyntheticPerception perception = synthetic_perception({box_body(kAxes, tumbling)}, three_seconds());
  BodyObservation& glimpse = perception.frames[0].bodies.at(0);
  glimpse.points = glimpse.points.leftCols(20).eval();
  glimpse.normals = glimpse.normals.leftCols(std::min<Eigen::Index>(20, glimpse.normals.cols())).eval();
  for (Feature& feature : glimpse.features) feature.track += 1'000'000;
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<BodyState> state;
  for (const PerceivedFrame& frame : perception.frames) state = estimator.step(frame, &frame.bodies[0]);
  ASSERT_TRUE(state);
  EXPECT_EQ(state->status, ObjectStatus::active);
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
  const Errors after = run(box_body(kAxes, swaying), options, 2.6);
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
    const Errors after = run(box_body(kAxes, tumbling), options, 3);
    EXPECT_EQ(after.frames, 30);
    EXPECT_LT(after.translation_m, 0.01) << until;
    EXPECT_LT(after.axes_m, 0.005) << until;
    // without colours nothing tells the box from itself turned by half
    EXPECT_LT(std::min(after.rotation_rad, std::abs(after.rotation_rad - M_PI)), 0.03) << until;
  }
}

TEST(BodyEstimator, ABodyThatWasHiddenIsFoundAgainByItsFeatures) {
  SyntheticOptions options = three_seconds();
  options.frames = 120;
  options.hidden = [](int, double t) { return t > 1.5 && t < 2.5; };
  const Errors after = run(box_body(kAxes, tumbling), options, 2.6);
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

}  // namespace
}  // namespace uniquadric
