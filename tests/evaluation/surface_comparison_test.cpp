#include "evaluation/metrics/surface_comparison.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/pcd.h"
#include "core/sequence/ply.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

// The cube from -1 to 1.
SurfaceDistance cube() {
  std::vector<Eigen::Vector3f> corners;
  for (int i = 0; i < 8; ++i)
    corners.emplace_back(i & 1 ? 1.f : -1.f, i & 2 ? 1.f : -1.f, i & 4 ? 1.f : -1.f);
  return {corners,
          {{0, 1, 3},
           {0, 3, 2},
           {4, 5, 7},
           {4, 7, 6},
           {0, 1, 5},
           {0, 5, 4},
           {2, 3, 7},
           {2, 7, 6},
           {0, 2, 6},
           {0, 6, 4},
           {1, 3, 7},
           {1, 7, 5}}};
}

// By the box's own formula, inside and outside.
double to_cube_m(const Eigen::Vector3d& p) {
  const Eigen::Vector3d beyond = p.cwiseAbs().array() - 1;
  return beyond.maxCoeff() <= 0 ? -beyond.maxCoeff() : beyond.cwiseMax(0).norm();
}

class SurfaceMetric : public testing::Test {
 protected:
  std::string write(const std::vector<Eigen::Vector3f>& points) {
    PcdFile file{{{"x"}, {"y"}, {"z"}, {"ring", 2, 'U'}}, std::int64_t(points.size()), {}, {}};
    for (const Eigen::Vector3f& p : points) {
      for (int k = 0; k < 3; ++k) file.put(p[k]);
      file.put(std::uint16_t(7));
    }
    write_pcd(temp_.path() / "points.pcd", file);
    return temp_.path() / "points.pcd";
  }

  TempFolder temp_;
};

TEST(SurfaceDistance, IsThatOfACubeInDoublePrecision) {
  const SurfaceDistance surface = cube();
  RandomStream random(3, "points", 0, 0);
  for (int i = 0; i < 2000; ++i) {
    const double reach = std::pow(10, -1 + 4 * random.uniform());
    const Eigen::Vector3d p(reach * random.uniform(-1, 1), reach * random.uniform(-1, 1),
                            reach * random.uniform(-1, 1));
    EXPECT_NEAR(surface.at(p), to_cube_m(p), 1e-12 * std::max(1., reach)) << p.transpose();
  }
  EXPECT_EQ(surface.at({5, 0, 0}, 1.5), 1.5);  // none is nearer
  EXPECT_EQ(surface.at({0.25, 1, -1}), 0);
}

TEST(SurfaceDistance, FromFarAwayIsThatOfTheBox) {
  const SurfaceDistance triangle({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}});
  for (const double far_m : {1e3, 2e3, 1e6}) EXPECT_NEAR(triangle.at({0.2, 0.2, far_m}), far_m, 1e-3 * far_m);
  EXPECT_EQ(triangle.at({0, 0, 1e6}, 5), 5);
}

TEST_F(SurfaceMetric, FiguresOfPointsAtKnownDistances) {
  constexpr float kNone = std::numeric_limits<float>::quiet_NaN();
  // 0, 0.25 inside, 0.5 outside, 5 off a corner (3, 4 over two sides), and one without coordinates.
  const SurfaceComparison found = compare_to_surface(
      write({{1, 0.5, 0.5}, {0, -0.75, 0}, {0.3f, 0.2f, 1.5}, {4, 5, 0}, {kNone, 0, 0}}), cube(), {});
  EXPECT_EQ(found.not_finite, 1u);
  EXPECT_EQ(found.distance_m.n, 4u);
  EXPECT_NEAR(found.distance_m.rmse, std::sqrt((0.0625 + 0.25 + 25) / 4), 1e-12);
  EXPECT_NEAR(found.distance_m.mean, 5.75 / 4, 1e-12);
  EXPECT_NEAR(found.distance_m.median, 0.375, 1e-12);
  EXPECT_NEAR(found.quantile_95_m, 0.5 + 0.85 * 4.5, 1e-12);  // at 2.85 of 0 to 3
  EXPECT_EQ(found.share_within, 0.25);
  const std::string ply = temp_.path() / "points.ply";
  write_surface_ply(ply, {{{1, 0.5, 0.5}, {0, -0.75, 0}, {0.3f, 0.2f, 1.5}, {4, 5, 0}}, {}}, "");
  EXPECT_EQ(compare_to_surface(ply, cube(), {}).distance_m.rmse, found.distance_m.rmse);
  SurfaceOptions wide;
  wide.within_m = 0.25;
  EXPECT_EQ(
      compare_to_surface(write({{1, 0, 0}, {0, 0.75, 0}, {0, 0, 1.5}, {9, 9, 9}}), cube(), wide).share_within,
      0.5);
}

TEST_F(SurfaceMetric, PointsOnTheSurfaceStayOnItWhereverItStands) {
  SurfaceOptions moved;
  moved.points_from_surface = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {10, -20, 30}};
  std::vector<Eigen::Vector3f> points;
  RandomStream random(5, "points", 0, 0);
  for (int i = 0; i < 300; ++i) {
    Eigen::Vector3d p(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1));
    p[i % 3] = i % 2 ? 1 : -1;
    points.push_back((moved.points_from_surface * p).cast<float>());
  }
  const std::string file = write(points);
  const SurfaceComparison found = compare_to_surface(file, cube(), moved);
  EXPECT_LT(found.distance_m.max, 4e-6);  // of the floats at 30 m
  EXPECT_EQ(found.share_within, 1);
  EXPECT_GT(compare_to_surface(file, cube(), {}).distance_m.min, 1);
}

TEST_F(SurfaceMetric, RefusesFilesWithoutPoints) {
  const auto refusal = [](const std::string& file) {
    return input_error([&] { compare_to_surface(file, cube(), {}); });
  };
  EXPECT_NE(refusal(write({})).find("points.pcd: has no finite point"), std::string::npos);
  EXPECT_NE(refusal(write({{0, 0, 0}, {0, 2e9f, 0}})).find("points.pcd: point 1 lies beyond"),
            std::string::npos);
  const std::string flat = temp_.path() / "flat.pcd";
  write_pcd(flat, {{{"x"}, {"y"}}, 0, {}, {}});
  EXPECT_NE(refusal(flat).find("flat.pcd: has no field z"), std::string::npos);
  write_text(flat, "VERSION 0.7\nPOINT 3\n");
  EXPECT_NE(refusal(flat).find("flat.pcd:2: 'POINT' is no entry"), std::string::npos);
  EXPECT_NE(refusal(temp_.path() / "none.pcd").find("none.pcd: cannot be read"), std::string::npos);
}

}  // namespace
}  // namespace uniquadric
