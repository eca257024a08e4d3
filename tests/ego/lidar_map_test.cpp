#include "estimator/ego/lidar_map.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/random.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kNoise_m = 0.03;  // half as much again as the points'

TEST(LidarMap, FindsThePlaneOfAWallThroughItsNoise) {
  RandomStream random(1, "map");
  const Vector3d normal = Vector3d(1, -2, 0.5).normalized();
  const Vector3d u = normal.unitOrthogonal(), v = normal.cross(u);
  const Vector3d place(40, -30, 2);
  LidarMap map{LidarMapOptions()};
  for (int i = 0; i < 50'000; ++i)
    map.add(place + random.uniform(-4, 4) * u + random.uniform(-4, 4) * v + 0.02 * random.normal() * normal);
  int asked = 0;
  for (; asked < 200; ++asked) {
    const Vector3d on_wall = place + random.uniform(-3, 3) * u + random.uniform(-3, 3) * v;
    const auto plane = map.plane_near(on_wall + 0.05 * random.normal() * normal, {kNoise_m});
    ASSERT_TRUE(plane);
    // A dozen cells of thirty points: good to 20 mm / sqrt(360) = 1 mm; five sigma.
    EXPECT_NEAR(plane->normal.dot(on_wall) + plane->offset_m, 0, 0.005);
    EXPECT_NEAR(plane->thickness_m, 0.02, 0.004);
    EXPECT_GT(std::abs(plane->normal.dot(normal)), std::cos(0.02));
  }
}

TEST(LidarMap, SmallFacesHaveTheirOwnPlanes) {
  LidarMap map{LidarMapOptions()};
  for (int i = 0; i < 200; ++i)
    for (int k = 0; k < 200; ++k) {
      map.add({0.02 * i, 0.02 * k, 0});
      map.add({0, 0.02 * i, 0.02 * k});  // a wall at right angles
    }
  const auto floor = map.plane_near({1.0, 2.0, 0.02}, {kNoise_m}),
             wall = map.plane_near({0.02, 2.0, 1.0}, {kNoise_m});
  ASSERT_TRUE(floor && wall);
  EXPECT_GT(std::abs(floor->normal.z()), 0.9999);
  EXPECT_GT(std::abs(wall->normal.x()), 0.9999);
}

// A fence 0.3 m before a wall by one row of a spinning sensor, and a wall by several.
TEST(LidarMap, OneRowOfBeamsTellsNoPlane) {
  const PlaneLimits limits{.max_thickness_m = kNoise_m, .min_breadth_m = 0.06, .min_rise_rad = 0.02};
  LidarMap one_row{LidarMapOptions()}, rows{LidarMapOptions()};
  for (int i = -100; i < 100; ++i) {
    const double x = 0.02 * i;
    one_row.add({x, i % 2 ? 20 : 20.3, 1.0}, 0.05);
    for (int row = -4; row < 5; ++row) rows.add({x, 20, 1.0 + 0.1 * row}, 0.05 + 0.005 * row);
  }
  const Vector3d on_wall(-1, 20, 1);
  EXPECT_FALSE(one_row.plane_near(on_wall, limits));
  EXPECT_TRUE(one_row.plane_near(on_wall, {kNoise_m, 0.06}));  // or else the row's own plane
  const auto wall = rows.plane_near(on_wall, limits);
  ASSERT_TRUE(wall);
  EXPECT_GT(std::abs(wall->normal.y()), 0.9999);
}

// One point a cell, about the origin: the cells' places come back, those of a single sight do not.
TEST(LidarMap, GivesBackTheMeansOfItsFinestCells) {
  LidarMap map{LidarMapOptions()};
  const double cell_m = LidarMapOptions().cell_m;
  std::vector<Vector3d> expected;
  for (int x = -5; x < 6; ++x)
    for (int y = -5; y < 6; ++y)
      for (const int z : {-3, 7}) {
        const Vector3d p = cell_m * (Vector3d(x, y, z) + Vector3d(0.3, 0.6, 0.2));
        map.add(p);
        if ((x + y) % 2 == 0) continue;
        map.add(p + Vector3d(0.02, -0.02, 0.04));
        expected.emplace_back(p + Vector3d(0.01, -0.01, 0.02));
      }
  std::vector<Vector3d> found = map.points();
  ASSERT_EQ(found.size(), expected.size());
  const auto by_place = [](const Vector3d& a, const Vector3d& b) {
    return std::lexicographical_compare(a.begin(), a.end(), b.begin(), b.end(),
                                        [](double u, double v) { return u < v - 1e-3; });
  };
  std::sort(found.begin(), found.end(), by_place);
  std::sort(expected.begin(), expected.end(), by_place);
  for (std::size_t i = 0; i < found.size(); ++i) EXPECT_LT((found[i] - expected[i]).norm(), 1e-6) << i;
}

TEST(LidarMap, HasNoPlaneWhereThereIsNone) {
  RandomStream random(2, "map");
  LidarMap map{LidarMapOptions()};
  EXPECT_FALSE(map.plane_near(Vector3d::Zero(), {kNoise_m}));
  for (int i = 0; i < 400; ++i) map.add({0.01 * i, 10, 0});  // a wire
  EXPECT_FALSE(map.plane_near({2, 10, 0}, {kNoise_m}));
  for (int i = 0; i < 3000; ++i)  // a tree
    map.add({random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)});
  EXPECT_FALSE(map.plane_near(Vector3d::Zero(), {kNoise_m}));
  EXPECT_FALSE(map.plane_near({30, 0, 0}, {kNoise_m}));
}

// The points of one ring on a wall (x = 0): a line that noise along the beams makes broad. Its plane would
// lie along the beams, not along the wall. A ring more, and there is a wall.
TEST(LidarMap, ALineWithNoiseIsNoPlane) {
  RandomStream random(3, "map");
  const auto add_ring = [&](LidarMap& map, double height_m) {
    for (int i = 0; i < 400; ++i)
      map.add({0.02 * random.normal(), 0.01 * i - 2, height_m + 0.003 * random.normal()});
  };
  LidarMapOptions options;
  options.cell_m = 0.5;
  LidarMap map(options);
  add_ring(map, 0.2);
  const PlaneLimits limits{kNoise_m, 2 * kNoise_m};
  ASSERT_TRUE(map.plane_near({0, 0, 0.2}, {kNoise_m}));
  EXPECT_LT(std::abs(map.plane_near({0, 0, 0.2}, {kNoise_m})->normal.x()), 0.1);
  EXPECT_FALSE(map.plane_near({0, 0, 0.2}, limits));
  add_ring(map, 0.9);
  const auto wall = map.plane_near({0, 0, 0.5}, limits);
  ASSERT_TRUE(wall);
  EXPECT_GT(std::abs(wall->normal.x()), 0.99);
}

// A step of 10 cm within a cell is no wall in between.
TEST(LidarMap, TwoWallsCloseTogetherAreNotOne) {
  LidarMapOptions options;
  options.levels = 1;
  LidarMap map(options);
  for (int i = 0; i < 60; ++i)
    for (int k = 0; k < 60; ++k) map.add({0.05 * i, 0.05 * k, (i + k) % 2 == 0 ? 0.05 : 0.15});
  EXPECT_FALSE(map.plane_near({1.5, 1.5, 0.1}, {kNoise_m}));
  EXPECT_TRUE(map.plane_near({1.5, 1.5, 0.1}, {0.1}));
}

TEST(LidarMap, ForgetsWhatIsFarAndWhatIsOld) {
  LidarMapOptions options;
  options.wide_levels = 0;
  options.levels = 1;
  options.max_blocks = 100;
  options.max_range_m = 50;
  LidarMap map(options);
  for (int x = 0; x < 40; ++x) map.add({1.0 * x, 0, 0});  // a block an edge of 1 m
  map.trim({0, 0, 0});
  EXPECT_EQ(map.blocks(), 40U);
  map.trim({70, 0, 0});
  EXPECT_EQ(map.blocks(), 20U);  // those whose middle is at least at x = 20
  for (int x = 41; x < 131; ++x) map.add({1.0 * x, 0, 0});
  options.max_range_m = 1000;
  map.trim({85, 0, 0});
  EXPECT_LE(map.blocks(), 100U);
  for (int i = 0; i < 5; ++i)
    for (int k = 0; k < 5; ++k) map.add({130.2 + 0.1 * i, 0.1 * k, 0.01});
  EXPECT_TRUE(map.plane_near({130.4, 0.2, 0}, {kNoise_m}));
}

}  // namespace
}  // namespace uniquadric
