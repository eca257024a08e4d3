#include "core/geometry/polygon.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

using Corners = std::vector<Eigen::Vector3f>;
using Triangles = std::vector<std::array<std::uint32_t, 3>>;

// Sum of areas that none may lie over another or the wrong way round: equal to the polygon's only then.
double total_area(const Corners& corners, const Triangles& triangles) {
  double total = 0;
  for (const auto& [a, b, c] : triangles)
    total += (corners[b] - corners[a]).cross(corners[c] - corners[a]).cast<double>().norm() / 2;
  return total;
}

constexpr double kSingle = 1e-5;  // a few operations of single precision on areas of some units

TEST(Polygon, AConvexOneIsTheFanOfItsFirstCorner) {
  Corners corners;
  Triangles fan;
  for (std::uint32_t i = 0; i < 9; ++i) {
    const double angle_rad = 2 * std::numbers::pi * i / 9;
    corners.push_back(Eigen::Vector3d(1, 2 * std::cos(angle_rad), std::sin(angle_rad)).cast<float>());
    if (i > 1) fan.push_back({0, i - 1, i});
  }
  EXPECT_EQ(triangulate(corners), fan);
  EXPECT_EQ(triangulate({corners[0], corners[1], corners[2]}), (Triangles{{0, 1, 2}}));
  for (const std::size_t few : {0, 1, 2})
    EXPECT_TRUE(triangulate({corners.begin(), corners.begin() + static_cast<std::ptrdiff_t>(few)}).empty());
}

// An L, an arrow, a comb, each from every corner on, both ways round, in a tilted plane.
TEST(Polygon, AConcaveOneIsCoveredOnce) {
  const std::vector<std::pair<Corners, double>> cases = {
      {{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}, {1, 1, 0}, {1, 3, 0}, {0, 3, 0}}, 5},
      {{{0, 0, 0}, {4, -2, 0}, {1, 0, 0}, {4, 2, 0}}, 2},
      {{{0, 0, 0},
        {5, 0, 0},
        {5, 3, 0},
        {4, 3, 0},
        {4, 1, 0},
        {3, 1, 0},
        {3, 3, 0},
        {2, 3, 0},
        {2, 1, 0},
        {1, 1, 0},
        {1, 3, 0},
        {0, 3, 0}},
       11}};
  const Eigen::AngleAxisf tilt(0.7F, Eigen::Vector3f(1, 2, -1).normalized());
  int tried = 0;
  for (const auto& [polygon, area] : cases)
    for (const bool turned : {false, true})
      for (std::size_t first = 0; first < polygon.size(); ++first, ++tried) {
        Corners corners;
        for (std::size_t i = 0; i < polygon.size(); ++i)
          corners.push_back(tilt * polygon[(first + (turned ? polygon.size() - i : i)) % polygon.size()]);
        const Triangles triangles = triangulate(corners);
        EXPECT_EQ(triangles.size(), polygon.size() - 2);
        EXPECT_NEAR(total_area(corners, triangles), area, kSingle) << first << turned;
        const Eigen::Vector3f outwards = tilt * Eigen::Vector3f(0, 0, turned ? -1 : 1);
        for (const auto& [a, b, c] : triangles)
          EXPECT_GE((corners[b] - corners[a]).cross(corners[c] - corners[a]).dot(outwards), -kSingle);
      }
  EXPECT_EQ(tried, 2 * (6 + 4 + 12));
}

TEST(Polygon, HasTwoTrianglesFewerThanCornersWhateverItIs) {
  const Corners line = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}};
  EXPECT_EQ(triangulate(line).size(), 2u);
  EXPECT_EQ(triangulate(Corners(7, {1, 2, 3})).size(), 5u);
  const Corners bow = {{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}};  // cuts itself, without vector area
  EXPECT_EQ(triangulate(bow).size(), 2u);
}

}  // namespace
}  // namespace uniquadric
