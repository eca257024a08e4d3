#include "core/geometry/box_symmetry.h"

#include <gtest/gtest.h>

#include <set>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;  // of products of a few rotations

Eigen::Matrix3d random_rotation(RandomStream& random) {
  return exp_so3({random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2)}).toRotationMatrix();
}

TEST(BoxSymmetry, TheTwentyFourAreDistinctRotationsThatFormAGroup) {
  const auto& rotations = box_rotations();
  const auto key = [](const Eigen::Matrix3d& P) { return std::vector<double>(P.data(), P.data() + 9); };
  std::set<std::vector<double>> set;
  for (const auto& P : rotations) {
    EXPECT_EQ(P.determinant(), 1);
    EXPECT_EQ((P * P.transpose()).eval(), Eigen::Matrix3d::Identity().eval());
    set.insert(key(P));
  }
  EXPECT_EQ(set.size(), 24u);
  EXPECT_EQ(rotations.front(), Eigen::Matrix3d::Identity().eval());
  for (const auto& P : rotations)
    for (const auto& Q : rotations) EXPECT_TRUE(set.contains(key(P * Q)));
}

TEST(BoxSymmetry, NearestUndoesAnyRenamingOfTheAxes) {
  RandomStream random(1, "box_symmetry");
  int cases = 0;
  for (const auto& P : box_rotations()) {
    const Eigen::Matrix3d reference = random_rotation(random);
    const Eigen::Matrix3d close = reference * exp_so3({0.2, -0.1, 0.3}).toRotationMatrix();
    const Eigen::Matrix3d found = nearest_box_rotation(close * P, reference);
    EXPECT_LT((P * found - Eigen::Matrix3d::Identity()).norm(), kRounding);
    ++cases;
  }
  EXPECT_EQ(cases, 24);
}

TEST(BoxSymmetry, RelabellingKeepsTheBody) {
  RandomStream random(2, "box_symmetry");
  const Ellipsoid ellipsoid{{Eigen::Quaterniond(random_rotation(random)), {1, 2, 3}}, {0.1, 0.2, 0.5}};
  const Eigen::Matrix4d expected = dual_quadric(ellipsoid.world_from_object, ellipsoid.semi_axes_m);
  for (const auto& P : box_rotations()) {
    const Ellipsoid other = relabel_axes(ellipsoid, P);
    EXPECT_LT((dual_quadric(other.world_from_object, other.semi_axes_m) - expected).norm(), kRounding);
  }
}

}  // namespace
}  // namespace uniquadric
