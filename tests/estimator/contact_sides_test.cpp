#include "estimator/window/contact_sides.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace uniquadric {
namespace {

// A body whose side `outward` lies on the floor z = 0 in its frame's own place, seen from somewhere above.
ShapeView view_on(const Eigen::Vector3d& outward, double position_m, RandomStream& random) {
  ShapeView view;
  const Eigen::Quaterniond upright = Eigen::Quaterniond::FromTwoVectors(outward, -Eigen::Vector3d::UnitZ());
  view.world_from_body.rotation = exp_so3({0, 0, random.uniform(-3, 3)}) * upright;
  view.world_from_body.translation = {random.uniform(-1, 1), random.uniform(-1, 1), position_m};
  view.world_from_camera = {exp_so3({2, random.uniform(-0.3, 0.3), 0.4}), {random.uniform(-1, 1), 0.3, 1.2}};
  view.contact = ContactPlane{view.world_from_camera.rotation.conjugate() * Eigen::Vector3d::UnitZ(),
                              view.world_from_camera.translation.z(), 0.002};
  return view;
}

TEST(ContactSides, AreWhereTheBodyStoodInItsOwnFrame) {
  RandomStream random(1, "views");
  std::vector<ShapeView> views;
  for (int i = 0; i < 6; ++i) views.push_back(view_on(-Eigen::Vector3d::UnitY(), 0.07, random));
  for (int i = 0; i < 4; ++i) views.push_back(view_on(Eigen::Vector3d::UnitX(), 0.12, random));
  views.push_back(view_on(Eigen::Vector3d(1, 0, 1).normalized(), 0.15, random));  // tips over an edge
  views.emplace_back();                                                           // in the air
  const auto sides = contact_sides(views);
  ASSERT_EQ(sides.size(), 2u);
  EXPECT_LT((sides[0].direction + Eigen::Vector3d::UnitY()).norm(), 1e-9);
  EXPECT_NEAR(sides[0].position_m, 0.07, 1e-9);
  EXPECT_LT((sides[1].direction - Eigen::Vector3d::UnitX()).norm(), 1e-9);
  EXPECT_NEAR(sides[1].position_m, 0.12, 1e-9);
}

// What hides a body's foot looks as if the body stood on it: but points of the body lie beyond it.
TEST(ContactSides, ThatTheBodyReachesThroughAreNone) {
  RandomStream random(3, "points");
  Eigen::Matrix3Xd points(3, 400);
  for (Eigen::Index i = 0; i < points.cols(); ++i)
    points.col(i) << random.uniform(-1, 1), random.uniform(-1, 1), 0.1 * random.uniform(-1, 1);
  const ContactSide below{-Eigen::Vector3d::UnitZ(), 0.1, 0.002, 0.01};
  ContactSide through = below, noisy = below;
  through.position_m = 0.07;  // 15 % of the points are beyond
  noisy.position_m = 0.096;   // 2 %
  std::vector<ContactSide> sides = {below, through, noisy};
  drop_crossed(sides, points);
  ASSERT_EQ(sides.size(), 2u);
  EXPECT_EQ(sides[0].position_m, below.position_m);
  EXPECT_EQ(sides[1].position_m, noisy.position_m);
  drop_crossed(sides, Eigen::Matrix3Xd(3, 0));
  EXPECT_EQ(sides.size(), 2u);
}

// A tilted box has its evidence on all sides; what stood on a plane is upright, and ends at it.
TEST(ContactSides, HoldTheShapeUprightAndEndItAtThePlane) {
  const Eigen::Vector3d half(0.1, 0.06, 0.08);
  RandomStream random(1, "points");
  DepthEvidence depth;
  depth.surface_points.resize(3, 300);
  for (Eigen::Index i = 0; i < 300; ++i) {  // the bottom is not seen
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-0.7, 1));
    const auto axis = i % 3;
    p[axis] = axis < 2 && random.uniform() < 0.5 ? -1 : 1;
    depth.surface_points.col(i) = p.cwiseProduct(half);
  }
  depth.contacts = {{-Eigen::Vector3d::UnitZ(), half.z(), 0.001, 0.01}};
  Shape start;
  start.body_from_object.rotation = exp_so3({0.2, -0.25, 0});
  start.semi_axes_m.setConstant(0.09);
  LongWindowOptions options;
  options.max_iterations = 60;
  options.offset_sigmas.rotation_rad = 1;
  const auto tilt = [](const Shape& shape) {
    return (shape.body_from_object.rotation * Eigen::Vector3d::UnitZ()).head<2>().norm();
  };
  const Shape upright = solve_shape(Camera{}, {}, depth, {}, start, options).shape;
  EXPECT_LT(tilt(upright), 0.01);
  EXPECT_NEAR(upright.body_from_object.translation.z() - upright.semi_axes_m.z(), -half.z(), 0.002);
  options.contacts = false;
  const Shape free = solve_shape(Camera{}, {}, depth, {}, start, options).shape;
  EXPECT_GT(std::abs(free.body_from_object.translation.z() - free.semi_axes_m.z() + half.z()), 0.002);
}

}  // namespace
}  // namespace uniquadric
