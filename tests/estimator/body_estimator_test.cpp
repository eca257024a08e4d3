#include "estimator/objects/body_estimator.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "body_run.h"
#include "core/geometry/superquadric.h"

namespace uniquadric {
namespace {

TEST(BodyEstimator, FindsPoseAndSizeOfATumblingBoxWithinMillimetres) {
  const Errors errors = largest_errors(box_body(kAxes, tumbling), three_seconds(), 1.5);
  EXPECT_EQ(errors.frames, 45);
  EXPECT_LT(errors.translation_m, 0.008);
  EXPECT_LT(errors.rotation_rad, 0.03);
  EXPECT_LT(errors.axes_m, 0.006);
}

TEST(BodyEstimator, AndOfAnEllipsoid) {
  const Errors errors = largest_errors(ellipsoid_body(kAxes, tumbling), three_seconds(), 2.0);
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
  const Errors errors = largest_errors(perception, body, three_seconds(), 1.5);
  EXPECT_EQ(errors.frames, 45);
  EXPECT_LT(errors.translation_m, 0.008);
  EXPECT_LT(errors.axes_m, 0.006);
}

// A box of 12 cm is thrown at 8 m/s, too quickly for its features. Its steady motion before says nothing of
// that.
TEST(BodyEstimator, FollowsThePointsOfABodyThatIsThrown) {
  static constexpr double kThrown_s = 2;
  const SyntheticBody body = box_body(0.2 * kAxes, [](double t) {
    Pose pose = tumbling(std::min(t, kThrown_s));
    const double flies_s = std::max(0.0, t - kThrown_s);
    pose.translation += flies_s * Eigen::Vector3d(8, 0, 1.5 - 4.905 * flies_s);
    return pose;
  });
  SyntheticOptions options = three_seconds();
  SyntheticPerception perception = synthetic_perception({body}, options);
  const auto first = static_cast<std::size_t>(kThrown_s * options.rate_hz), last = first + 6;
  perception.frames.resize(last);
  for (std::size_t i = first; i < last; ++i) {
    perception.frames[i].bodies.at(0).features.clear();
    perception.frames[i].bodies.at(0).motion.reset();
  }
  BodyOptions without;
  without.lifecycle.follows_points = without.alignment.impacts = false;
  EXPECT_LT(largest_errors(perception, body, options, kThrown_s).translation_m, 0.02);
  EXPECT_GT(largest_errors(perception, body, options, kThrown_s, without).translation_m, 0.2);
}

// Six sightings of a box at rest that agree on a motion of its own, as of a highlight that wanders over it.
TEST(BodyEstimator, DoesNotFollowFewFeaturesThatLeaveTheSurface) {
  const SyntheticBody body = box_body(kAxes, [](double) { return tumbling(0); });
  const SyntheticOptions options = three_seconds();
  SyntheticPerception perception = synthetic_perception({body}, options);
  for (PerceivedFrame& frame : perception.frames) {
    BodyObservation& seen = frame.bodies.at(0);
    seen.motion.reset();
    std::erase_if(seen.features, [](const Feature& f) { return f.track % 7 != 0; });
    if (seen.features.size() > 6) seen.features.resize(6);
    const double t = 1e-9 * static_cast<double>(frame.stamp_ns);
    if (t < 1.5) continue;
    const Eigen::Vector3d wanders_m(0.3, 0, 0);  // in the camera's frame, at once
    for (Feature& feature : seen.features) {
      const Eigen::Vector3d at = feature.depth_m * *perception.camera.unproject(feature.pixel) + wanders_m;
      feature.pixel = *perception.camera.project(at);
    }
  }
  BodyOptions without;
  without.lifecycle.weighs_evidence = false;
  EXPECT_LT(largest_errors(perception, body, options, 1.5).translation_m, 0.02);
  EXPECT_GT(largest_errors(perception, body, options, 1.5, without).translation_m, 0.2);
}

// One exponent makes it a box or an egg.
TEST(BodyEstimator, AndOfADisc) {
  const SyntheticBody disc = cylinder_body(0.25, 0.04, tumbling);
  EXPECT_LT(largest_errors(disc, three_seconds(), 2.0).axes_m, 0.006);
  BodyOptions one;
  one.shape.long_window.exponents = 1;
  EXPECT_GT(largest_errors(disc, three_seconds(), 2.0, one).axes_m, 0.006);
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
  const Errors errors = largest_errors(box_body({0.4, 0.03, 0.03}, tumbling), options, 2.0);
  EXPECT_LT(errors.translation_m, 0.01);
  EXPECT_LT(errors.axes_m, 0.01);
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

// A box or a cylinder of few centimetres. Of rounder edges and larger axes its outlines are hardly others.
TEST(BodyEstimator, TakesWhatMayBeABoxForABox) {
  SyntheticOptions options = three_seconds();
  options.outline_sigma_px = 1.5;
  options.point_sigma_m = 0.004;
  BodyOptions free;
  free.shape.plain_shapes = false;
  for (const SyntheticBody& body : {box_body(0.2 * kAxes, tumbling), cylinder_body(0.03, 0.05, tumbling)})
    EXPECT_LT(largest_errors(body, options, 1.5).axes_m,
              0.95 * largest_errors(body, options, 1.5, free).axes_m);
}

TEST(BodyEstimator, AndLeavesAPillowItsRoundEdges) {
  constexpr double kExponent = 1.5;
  SyntheticBody pillow = ellipsoid_body(kAxes, tumbling);
  for (Eigen::Index i = 0; i < pillow.points.cols(); ++i)
    pillow.points.col(i) = superellipsoid_support_point(kAxes, kExponent, pillow.normals.col(i));
  const SyntheticPerception perception = synthetic_perception({pillow}, three_seconds());
  BodyEstimator estimator(1, perception.camera, {}, 1);
  std::optional<BodyState> state;
  for (const PerceivedFrame& frame : perception.frames) state = estimator.step(frame, &frame.bodies[0]);
  const SuperExponents& q = state->shape.exponents;
  for (const double exponent : {q.outline, q.upper, q.lower}) EXPECT_NEAR(exponent, kExponent, 0.15);
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

}  // namespace
}  // namespace uniquadric
