#include "simulator/map/occupancy_map.h"

#include <gtest/gtest.h>
#include <octomap/OcTree.h>

#include "core/base/random.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// The second way: the least distance from the cube's centre, in its own norm, over a dense sampling of the
// triangle.
double sampled_distance(const std::array<Vector3d, 3>& t, const Vector3d& center) {
  constexpr int kSteps = 200;
  double least = 1e9;
  for (int i = 0; i <= kSteps; ++i)
    for (int j = 0; i + j <= kSteps; ++j) {
      const double u = static_cast<double>(i) / kSteps, v = static_cast<double>(j) / kSteps;
      least = std::min(least, (t[0] + u * (t[1] - t[0]) + v * (t[2] - t[0]) - center).cwiseAbs().maxCoeff());
    }
  return least;
}

TEST(TriangleMeetsCube, AgreesWithSampling) {
  constexpr double kStep = 0.03;  // m: the sampling's, for triangles of 3 m; within it either answer may hold
  RandomStream random(1, "triangles");
  int met = 0, apart = 0;
  for (int i = 0; i < 400; ++i) {
    std::array<Vector3d, 3> t;
    for (Vector3d& p : t) p = Vector3d(random.normal(), random.normal(), random.normal());
    const Vector3d center(random.normal(), random.normal(), random.normal());
    const double half = random.uniform(0.1, 0.8), distance = sampled_distance(t, center);
    if (std::abs(distance - half) < kStep) continue;
    EXPECT_EQ(triangle_meets_cube(t, center, half), distance < half) << i;
    ++(distance < half ? met : apart);
  }
  EXPECT_GT(met, 50);
  EXPECT_GT(apart, 50);
}

// A horizontal square of 1 m at z = 0.25 with cells of 0.1 m, between the cells' borders on all sides.
TEST(OccupancyMap, OccupiesTheCellsOfASquareAndNoOthers) {
  Body floor;
  Mesh mesh;
  for (const auto& [x, y] : {std::pair{-0.45f, -0.45f}, {0.45f, -0.45f}, {0.45f, 0.45f}, {-0.45f, 0.45f}})
    mesh.positions.emplace_back(x, y, 0.25f);
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  floor.meshes.push_back(mesh);
  const TempFolder temp;
  const std::string path = temp.path() / "map.bt";
  write_occupancy_map(path, {floor}, 0.1);
  octomap::OcTree tree(path);
  int occupied = 0;
  for (auto leaf = tree.begin_leafs(), end = tree.end_leafs(); leaf != end; ++leaf) {
    ASSERT_TRUE(tree.isNodeOccupied(*leaf));
    EXPECT_NEAR(leaf.getZ(), 0.25, 1e-6);
    ++occupied;
  }
  EXPECT_EQ(occupied, 100);
  EXPECT_EQ(tree.getResolution(), 0.1);
  EXPECT_NE(tree.search(0.05, 0.05, 0.25), nullptr);
  EXPECT_EQ(tree.search(0.05, 0.05, 0.45), nullptr);
}

}  // namespace
}  // namespace uniquadric
