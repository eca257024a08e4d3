// A k-d tree against a look at every point.
#include "estimator/base/point_tree.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kEverywhere = std::numeric_limits<double>::infinity();

Eigen::Matrix3Xd random_points(int count, const char* stream) {
  RandomStream random(1, stream);
  Eigen::Matrix3Xd points(3, count);
  for (double& x : points.reshaped()) x = random.uniform(-1, 1);
  return points;
}

// Distances from `p` in single precision, nearest first, each with its point.
std::vector<PointTree::Neighbour> sorted(const Eigen::Matrix3Xd& points, const Eigen::Vector3d& p) {
  std::vector<PointTree::Neighbour> all;
  for (int i = 0; i < points.cols(); ++i)
    all.push_back({i, (points.col(i).cast<float>() - p.cast<float>()).squaredNorm()});
  std::ranges::sort(all, {}, &PointTree::Neighbour::squared_m2);
  return all;
}

TEST(PointTree, FindsTheNearestInOrder) {
  const Eigen::Matrix3Xd points = random_points(2000, "points"), places = random_points(200, "places");
  const PointTree tree(points);
  for (const auto& p : places.colwise()) {
    std::array<PointTree::Neighbour, 6> found;
    ASSERT_EQ(tree.nearest(p, kEverywhere, found).size(), 6u);
    const auto all = sorted(points, p);
    for (std::size_t i = 0; i < found.size(); ++i) {
      EXPECT_EQ(found[i].index, all[i].index);
      EXPECT_FLOAT_EQ(found[i].squared_m2, all[i].squared_m2);
    }
  }
}

TEST(PointTree, FindsNothingBeyondItsReach) {
  const Eigen::Matrix3Xd points = random_points(500, "points"), places = random_points(100, "places");
  const PointTree tree(points);
  int partly = 0;
  for (const auto& p : places.colwise()) {
    constexpr double kReach_m = 0.25;
    std::array<PointTree::Neighbour, 6> places_found;
    std::vector<int> all;
    tree.within(p, kReach_m, all);
    const auto expected = std::ranges::count_if(
        sorted(points, p), [](const auto& near) { return near.squared_m2 < kReach_m * kReach_m; });
    EXPECT_EQ(std::ssize(all), expected);
    for (const int i : all) EXPECT_LT((points.col(i) - p).norm(), kReach_m + 1e-6);
    const auto found = tree.nearest(p, kReach_m, places_found);
    EXPECT_EQ(std::ssize(found), std::min<std::ptrdiff_t>(6, expected));
    partly += expected > 0 && expected < 6;
  }
  EXPECT_GT(partly, 10);
}

TEST(PointTree, OfFewPointsFindsThese) {
  std::array<PointTree::Neighbour, 6> found;
  EXPECT_TRUE(PointTree(Eigen::Matrix3Xd(3, 0)).nearest({0, 0, 0}, kEverywhere, found).empty());
  EXPECT_TRUE(PointTree(Eigen::Matrix3Xd::Ones(3, 2)).nearest({0, 0, 0}, kEverywhere, {}).empty());
  const PointTree twice(Eigen::Matrix3Xd::Ones(3, 2));  // two points in one place
  const auto both = twice.nearest({1, 1, 1}, kEverywhere, found);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_NE(both[0].index, both[1].index);
  EXPECT_EQ(both[1].squared_m2, 0);
}

}  // namespace
}  // namespace uniquadric
