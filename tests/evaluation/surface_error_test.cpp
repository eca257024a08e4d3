#include "evaluation/metrics/surface_error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

// Sides x, y, z of a box about the origin, two triangles each; as many sides as asked for.
SurfaceFile box(const Eigen::Vector3f& half, int sides = 6) {
  SurfaceFile mesh;
  for (int side = 0; side < sides; ++side) {
    const int axis = side / 2, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const auto first = static_cast<std::uint32_t>(mesh.points.size());
    for (int i = 0; i < 4; ++i) {
      Eigen::Vector3f p;
      p[axis] = side % 2 ? half[axis] : -half[axis];
      p[u] = i & 1 ? half[u] : -half[u];
      p[v] = i & 2 ? half[v] : -half[v];
      mesh.points.push_back(p);
    }
    mesh.triangles.push_back({first, first + 1, first + 3});
    mesh.triangles.push_back({first, first + 3, first + 2});
  }
  return mesh;
}

SurfaceFile points_of(const std::vector<Eigen::Vector3d>& samples) {
  SurfaceFile file;
  for (const Eigen::Vector3d& p : samples) file.points.push_back(p.cast<float>());
  return file;
}

TEST(SurfaceSamples, LieOnTheMeshByItsArea) {
  const Eigen::Vector3f half(0.5, 1, 2);
  const auto samples = sample_surface(box(half), 20'000);
  ASSERT_EQ(samples.size(), 20'000u);
  int on_x = 0;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double upper = 0;
  for (const Eigen::Vector3d& p : samples) {
    const Eigen::Vector3d off = (p.cwiseAbs() - half.cast<double>()).cwiseAbs();
    EXPECT_LT(off.minCoeff(), 1e-9);
    if (off.x() < 1e-9) {
      ++on_x;
      upper += p.y() > 0.5;  // a quarter of the side
    }
    mean += p / 20'000;
  }
  EXPECT_NEAR(on_x / 20'000., 8 / (8 + 4 + 2.), 1e-3);  // areas 1x2, 0.5x2, 0.5x1, times 4
  EXPECT_NEAR(upper / on_x, 0.25, 5e-3);
  EXPECT_LT(mean.norm(), 5e-3);
  EXPECT_TRUE(sample_surface({{{0, 0, 0}, {1, 1, 1}}, {}, {{0, 1, 1}}}, 10).empty());
}

TEST(SurfaceErrorFigures, OfABoxThatIsTooLargeByKnownAmounts) {
  const SurfaceFile truth = box({0.5, 0.5, 0.5});
  SurfaceFile estimate;
  for (int i = 0; i < 100; ++i)  // 0.01, 0.02, .. 1 m above the upper side's middle
    estimate.points.emplace_back(0, 0, 0.5F + 0.01F * static_cast<float>(i + 1));
  const auto found = surface_error(truth, estimate, Pose());
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->error_m.median, 0.505, 1e-6);
  EXPECT_NEAR(found->error_m.mean, 0.505, 1e-6);
  EXPECT_NEAR(found->quantile_90_m, 0.01 + 0.9 * 0.99, 1e-6);
  EXPECT_NEAR(found->within_m, 0.05 * std::sqrt(3), 1e-7);
  // within_m of a point 0.01 m above: a disc of the cube's upper side
  const double r2 = found->within_m * found->within_m - 0.01 * 0.01;
  EXPECT_NEAR(found->completeness, std::numbers::pi * r2 / 6, 1e-3);
}

TEST(SurfaceErrorFigures, CompletenessIsTheShareThatWasSeen) {
  const SurfaceFile truth = box({0.5, 0.5, 0.5});
  const auto half = surface_error(truth, points_of(sample_surface(box({0.5, 0.5, 0.5}, 3), 5000)), Pose());
  ASSERT_TRUE(half);
  EXPECT_LT(half->error_m.max, 1e-7);
  // both sides x, one side y; of the other, and of both sides z, strips along the edges that they share
  const double strip = half->within_m, of_y = 2 * strip, of_z = 1 - (1 - 2 * strip) * (1 - strip);
  EXPECT_NEAR(half->completeness, (3 + of_y + 2 * of_z) / 6, 4e-3);  // points are 0.02 m apart
  EXPECT_EQ(surface_error(truth, points_of(sample_surface(truth, 5000)), Pose())->completeness, 1);
}

// A mesh in the place of points, in a frame and unit of its own.
TEST(SurfaceErrorFigures, DoNotDependOnTheFrame) {
  const SurfaceFile truth = box({0.5F, 0.3F, 0.2F});
  const Pose truth_from_estimate{Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {1, -2, 3}};
  SurfaceFile moved = truth;
  for (Eigen::Vector3f& p : moved.points)
    p = (truth_from_estimate.inverse() * p.cast<double>().eval() / 4).cast<float>();
  const auto found = surface_error(truth, moved, truth_from_estimate, 4);
  ASSERT_TRUE(found);
  EXPECT_LT(found->error_m.max, 2e-6);  // of floats at 4 m
  EXPECT_EQ(found->completeness, 1);
  EXPECT_GT(surface_error(truth, moved, Pose())->error_m.min, 0.1);
}

TEST(SurfaceErrorFigures, OfNothingAreNone) {
  EXPECT_FALSE(surface_error(box({1, 1, 1}), {}, Pose()));
  EXPECT_FALSE(surface_error({{{0, 0, 0}}, {}, {{0, 0, 0}}}, points_of({{1, 0, 0}}), Pose()));
}

}  // namespace
}  // namespace uniquadric
