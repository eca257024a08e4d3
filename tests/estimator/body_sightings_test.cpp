// As of when a sighting counts, and which ones begin no body.
#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "body_run.h"

namespace uniquadric {
namespace {

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

// Of a body a metre long that is slanted in its frame: half a metre along it is little, across it is all.
TEST(BodyEstimator, APoseIsPlacedByTheBodysSizeInEveryDirection) {
  Shape shape;
  shape.semi_axes_m = {1, 0.1, 0.1};
  shape.body_from_object.rotation = exp_so3(Eigen::Vector3d(0, 0, 0.6));
  const auto with_sigma_along = [&](const Eigen::Vector3d& axis) {
    Matrix6d covariance = 1e-4 * Matrix6d::Identity();
    const Eigen::Vector3d off = shape.body_from_object.rotation * axis;
    covariance.topLeftCorner<3, 3>() += 0.25 * off * off.transpose();
    return covariance;
  };
  EXPECT_TRUE(is_placed(with_sigma_along(Eigen::Vector3d::UnitX()), shape));
  EXPECT_FALSE(is_placed(with_sigma_along(Eigen::Vector3d::UnitY()), shape));
  EXPECT_FALSE(is_placed(with_sigma_along(Eigen::Vector3d::UnitZ()), shape));
}

}  // namespace
}  // namespace uniquadric
