#include "evaluation/metrics/body_surface.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

constexpr SuperExponents kBox{1, 1, 1};

double area(const SurfaceFile& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += (mesh.points[b] - mesh.points[a]).cross(mesh.points[c] - mesh.points[a]).norm() / 2;
  return sum;
}

SurfaceScore score(const Superellipsoid& truth, const Superellipsoid& estimate, const Pose& pose,
                   double within_m = 0.01) {
  return surface_score(reference_surface(tessellate(truth)), reference_surface(tessellate(estimate)), pose,
                       within_m);
}

TEST(BodySurface, TessellationHasTheAreaAndLiesOnTheBody) {
  EXPECT_NEAR(area(tessellate({{1, 2, 3}, kBox})), 88, 1e-4);
  EXPECT_NEAR(area(tessellate({{1, 1, 1}})), 4 * std::numbers::pi, 0.01 * 4 * std::numbers::pi);
  const Superellipsoid body{{1, 2, 3}, {1.2, 1.5, 1.8}, 1};
  for (const Eigen::Vector3f& point : tessellate(body).points)
    EXPECT_NEAR(gauge(body, point.cast<double>()), 1, 1e-5);
}

TEST(BodySurface, SameBodyScoresOne) {
  const SurfaceScore same = score({{1, 2, 3}, {1.2, 1.5, 1.8}, 1}, {{1, 2, 3}, {1.2, 1.5, 1.8}, 1}, {});
  EXPECT_EQ(same.f1, 1);
  EXPECT_LT(same.chamfer_m, 1e-5);
}

// Of balls with one centre every point is as far off as the radii differ.
TEST(BodySurface, OfBallsInOneAnother) {
  const SurfaceScore apart = score({{1, 1, 1}}, {{1.1, 1.1, 1.1}}, {}, 0.05);
  EXPECT_EQ(apart.f1, 0);
  EXPECT_NEAR(apart.chamfer_m, 0.1, 0.005);
  EXPECT_EQ(score({{1, 1, 1}}, {{1.1, 1.1, 1.1}}, {}, 0.12).f1, 1);
}

// A cube moved by 0.1 along x. The side that moved out is 0.1 off. The one that moved in is so but for its
// rim, which is near the four others: (1 - max(|y|, |z|)) off. Those slide along themselves; 1 / 20 stands
// out.
TEST(BodySurface, OfAMovedBox) {
  const Pose moved{Eigen::Quaterniond::Identity(), {0.1, 0, 0}};
  const SurfaceScore s = score({{1, 1, 1}, kBox}, {{1, 1, 1}, kBox}, moved, 0.05);
  const double rim = 1 - 0.95 * 0.95, mean_of_inner_side_m = 0.081 + (1.0 / 3 - 0.324);
  EXPECT_NEAR(s.f1, (4 * (1 - 0.025) + rim) / 6, 0.01);
  EXPECT_NEAR(s.chamfer_m, (0.1 + mean_of_inner_side_m + 4 * 0.05 * 0.05) / 6, 0.001);
}

TEST(BodySurface, ToleranceIsAShareOfTheExtentButTenMillimetresAtLeast) {
  EXPECT_NEAR(surface_tolerance_m(tessellate({{0.1, 0.1, 0.1}})), 0.01, 1e-9);
  EXPECT_NEAR(surface_tolerance_m(tessellate({{1, 2, 3}, kBox})), 0.06, 1e-6);
}

}  // namespace
}  // namespace uniquadric
