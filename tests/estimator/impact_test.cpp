// What hits something, and turns up faces that were not seen before.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "body_run.h"
#include "core/geometry/superquadric.h"
#include "estimator/objects/assumed_surface.h"

namespace uniquadric {
namespace {

TEST(AssumedSurface, CoversTheShapeWhereNothingWasSeen) {
  const Pose body_from_object{exp_so3({0.2, -0.4, 1}), {0.3, 0.1, 0.5}};
  SurfaceModel model;
  model.body_from_object = body_from_object;
  model.shape = Superellipsoid{{0.2, 0.1, 0.05}, {1.02, 1.02, 1.02}};
  model.points.resize(3, 21 * 11);
  for (Eigen::Index i = 0; i < model.points.cols(); ++i)
    model.points.col(i) = body_from_object * Eigen::Vector3d(0.02 * static_cast<double>(i % 21 - 10),
                                                             0.02 * static_cast<double>(i / 21 - 5), 0.05);
  model.normals = (body_from_object.rotation * Eigen::Vector3d::UnitZ()).replicate(1, model.points.cols());
  assume_unseen(model);
  ASSERT_GT(model.assumed_points.cols(), 100);
  const Pose object_from_body = body_from_object.inverse();
  double below_m = 1, beside_m = 1;
  for (Eigen::Index i = 0; i < model.assumed_points.cols(); ++i) {
    const Eigen::Vector3d p = object_from_body * model.assumed_points.col(i),
                          n = object_from_body.rotation * model.assumed_normals.col(i);
    EXPECT_NEAR(gauge(*model.shape, p), 1, 1e-9);
    EXPECT_LT(n.z(), 0.9) << p.transpose();  // the side that was seen
    if (n.z() < -0.9) below_m = std::min(below_m, (p - Eigen::Vector3d(0.1, 0.05, -0.05)).norm());
    if (n.x() > 0.9) beside_m = std::min(beside_m, (p - Eigen::Vector3d(0.2, 0, 0)).norm());
  }
  EXPECT_LT(below_m, 0.03);
  EXPECT_LT(beside_m, 0.03);
}

TEST(AssumedSurface, IsOfShapesWhoseSidesAreKnown) {
  Shape shape;
  shape.semi_axes_m = {0.2, 0.1, 0.05};  // 0.1 m in the geometric mean: sigmas below 12.5 mm
  EXPECT_FALSE(is_known_all_around(shape));
  shape.variances.setConstant(std::pow(0.012, 2));
  EXPECT_TRUE(is_known_all_around(shape));
  shape.variances[1] = std::pow(0.013, 2);
  EXPECT_FALSE(is_known_all_around(shape));
}

// A slab at rest, of which one side was seen for two seconds. It is struck, within a frame it is turned by 46
// degrees, and it turns on. No feature is found from then on.
TEST(Impact, ABodyThatIsStruckIsFoundAgain) {
  static constexpr double kStruck_s = 2, kSeen_s = 0.4;
  const SyntheticBody slab = box_body({0.15, 0.11, 0.03}, [](double t) {
    Pose pose = tumbling(0);
    const double after_s = t - kStruck_s;
    if (after_s < 0) return pose;
    pose.translation += Eigen::Vector3d(0.05 + 0.5 * after_s, 0, 0.05);
    pose.rotation = exp_so3({-0.8 - 1.5 * after_s, 0, 0}) * pose.rotation;
    return pose;
  });
  const SyntheticOptions options = three_seconds();
  SyntheticPerception perception = synthetic_perception({slab}, options);
  const auto first = static_cast<std::size_t>(kStruck_s * options.rate_hz);
  perception.frames.resize(first + static_cast<std::size_t>(kSeen_s * options.rate_hz));
  for (std::size_t i = first; i < perception.frames.size(); ++i) {
    perception.frames[i].bodies.at(0).features.clear();
    perception.frames[i].bodies.at(0).motion.reset();
  }
  BodyOptions without;
  without.alignment.impacts = false;
  const Errors errors = largest_errors(perception, slab, options, kStruck_s + 0.15);
  EXPECT_GE(errors.frames, 3);
  EXPECT_LT(errors.translation_m, 0.01);
  EXPECT_LT(errors.rotation_rad, 0.1);
  EXPECT_GT(largest_errors(perception, slab, options, kStruck_s + 0.15, without).rotation_rad, 0.5);
}

// A box of which three sides were seen for a second. Struck, it turns by a right angle within a quarter of
// one and shows two others, of which no feature is found.
TEST(Impact, ABodyThatWentAstrayComesBackToItsShape) {
  static constexpr double kStruck_s = 1, kTurning_s = 0.25;
  const SyntheticBody box = box_body({0.18, 0.08, 0.16}, [](double t) {
    Pose pose = tumbling(std::min(t, kStruck_s));
    const double turned = std::clamp((t - kStruck_s) / kTurning_s, 0.0, 1.0);
    pose.rotation = exp_so3({0.5 * std::numbers::pi * turned, 0, 0}) * pose.rotation;
    return pose;
  });
  const SyntheticOptions options = three_seconds();
  SyntheticPerception perception = synthetic_perception({box}, options);
  const auto first = static_cast<std::size_t>(kStruck_s * options.rate_hz);
  for (std::size_t i = first; i < perception.frames.size(); ++i) {
    perception.frames[i].bodies.at(0).features.clear();
    perception.frames[i].bodies.at(0).motion.reset();
  }
  BodyOptions without;
  without.alignment.impacts = false;
  const Errors errors = largest_errors(perception, box, options, 2),
               before = largest_errors(perception, box, options, 2, without);
  EXPECT_GE(errors.frames, 20);
  EXPECT_LT(errors.translation_m, 0.01);
  EXPECT_LT(errors.rotation_rad, 0.05);
  EXPECT_LT(errors.axes_m, 0.01);
  EXPECT_GT(before.rotation_rad, 0.1);
}

}  // namespace
}  // namespace uniquadric
