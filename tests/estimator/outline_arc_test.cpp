// The factors of the long window in closed loop: offset, axes and exponents from outlines alone, over an arc
// of 40 degrees. benchmarks/outline_arc prints the full table.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/estimator/arc_scenario.h"

namespace uniquadric {
namespace {

double median_iou(const HullBody& body, const ArcOptions& options) {
  std::vector<double> iou;
  for (int trial = 0; trial < 5; ++trial) iou.push_back(run_arc(body, options, trial).iou);
  std::sort(iou.begin(), iou.end());
  return iou[2];
}

ArcOptions without_noise() {
  ArcOptions options;
  options.noise_px = options.drift_m = options.drift_rad = 0;
  return options;
}

ArcOptions quadric() {
  ArcOptions options;
  options.exponents = 0;
  return options;
}

TEST(OutlineArc, SupportOfAHullIsThatOfItsCornersAndOfASphereItsOutline) {
  const Camera camera;
  const Pose at{exp_so3({0.3, -0.2, 0.5}), {0.2, 0.1, 3}};
  const Eigen::Vector2d n(0.6, -0.8);
  const HullBody ball = hull_ellipsoid("ball", Eigen::Vector3d::Constant(0.2));
  const HullBody box_of_no_size = hull_box("ball", Eigen::Vector3d::Constant(0.2), 0.2);
  EXPECT_NEAR(support_px(ball, camera, at, n), support_px(box_of_no_size, camera, at, n), 1e-9);
  const HullBody box = hull_box("box", {0.2, 0.3, 0.1});
  EXPECT_NEAR(support_px(box, camera, at, n),
              support_px(hull_box("box", {0.2, 0.3, 0.1}, 1e-6), camera, at, n), 1e-2);
}

TEST(OutlineArc, BoxesAndEllipsoidsComeOutExactlyWithoutNoise) {
  for (const HullBody& body : arc_bodies()) {
    if (body.name == "car" || body.name == "rounded box") continue;  // of no such family
    EXPECT_GT(median_iou(body, without_noise()), 0.985) << body.name;
  }
  ArcOptions conic = without_noise();
  conic.directions = 4;
  conic.exponents = 0;
  conic.conic = true;
  EXPECT_GT(median_iou(arc_bodies()[2], conic),
            0.97);  // the ellipsoid; a RotBbox is no outline's tangent ellipse
}

TEST(OutlineArc, SixteenTangentsGiveTheShapeUnderNoiseAndDrift) {
  for (const HullBody& body : arc_bodies()) {
    if (body.name == "car") continue;
    const double ours = median_iou(body, {});
    EXPECT_GT(ours, 0.93) << body.name;
    ArcOptions soft;
    soft.hard = false;
    EXPECT_GT(median_iou(body, soft), 0.93) << body.name;
  }
}

// A box's outline is larger than that of its inscribed ellipsoid: the model is at fault, not the views.
TEST(OutlineArc, TheQuadricIsTooLargeForBoxesFromAnyArc) {
  for (const HullBody& body : arc_bodies()) {
    if (body.balls.empty()) continue;
    for (const double arc_rad : {0.698, 6.03}) {
      ArcOptions options = quadric();
      options.arc_rad = arc_rad;
      EXPECT_LT(median_iou(body, options), 0.55) << body.name;
    }
  }
}

TEST(OutlineArc, ThreeExponentsMendABodyThatIsNotCentrallySymmetric) {
  ArcOptions one, three;
  one.arc_rad = three.arc_rad = 1.571;
  three.exponents = 3;
  const double before = median_iou(hull_car(), one), after = median_iou(hull_car(), three);
  EXPECT_GT(after, 0.8);
  EXPECT_GT(after, before + 0.2);
  three.sides = true;
  EXPECT_GT(median_iou(hull_car(), three), 0.88);
}

}  // namespace
}  // namespace uniquadric
