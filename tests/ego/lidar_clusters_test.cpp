// Bodies in a scan, and their tracks over several.
#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

#include "core/base/random.h"
#include "estimator/lidar/cluster_tracker.h"
#include "estimator/shape/lidar_clusters.h"

namespace uniquadric {
namespace {
using Eigen::Vector3d;

// Points of an upright rectangle or a level one: from `low` to `high`, one of the extents being none.
void add_grid(const Vector3d& low, const Vector3d& high, double step_m, std::vector<Vector3d>& points) {
  const Eigen::Vector3i counts = ((high - low) / step_m).cast<int>();
  for (int i = 0; i <= counts.x(); ++i)
    for (int j = 0; j <= counts.y(); ++j)
      for (int k = 0; k <= counts.z(); ++k) points.push_back(low + step_m * Vector3d(i, j, k));
}

Eigen::Matrix3Xd matrix_of(const std::vector<Vector3d>& points) {
  Eigen::Matrix3Xd result(3, std::ssize(points));
  for (std::size_t i = 0; i < points.size(); ++i) result.col(static_cast<Eigen::Index>(i)) = points[i];
  return result;
}

TEST(LidarClusters, GroundIsTheSlopeUnderEverything) {
  std::vector<Vector3d> points;
  RandomStream random(1, "test");
  add_grid({-20, -20, 0}, {20, 20, 0}, 0.5, points);
  for (auto& p : points) p.z() = -2 + 0.05 * p.x() - 0.02 * p.y() + 0.02 * random.normal();
  add_grid({0, 0, 1.5}, {12, 12, 1.5}, 0.3, points);  // a roof, level and dense
  add_grid({-20, 8, -3}, {20, 8, 5}, 0.3, points);    // a wall
  const auto ground = find_ground(matrix_of(points), {}, 3, 0);
  ASSERT_TRUE(ground);
  for (const Vector3d& p : {Vector3d(-15, -15, 0), Vector3d(15, -15, 0), Vector3d(0, 5, 0)})
    EXPECT_NEAR(ground->height_of(p), 2 - 0.05 * p.x() + 0.02 * p.y(),
                0.08);  // m: the lowest points lie lower
  std::vector<Vector3d> wall;
  add_grid({-20, 8, -3}, {20, 8, 5}, 0.3, wall);
  EXPECT_FALSE(find_ground(matrix_of(wall), {}, 3, 0));
}

TEST(LidarClusters, BodiesApartFromWallsAndKerbs) {
  std::vector<Vector3d> points;
  add_grid({0, 0, 0}, {0, 2, 1.5}, 0.2, points);
  const auto first = std::ssize(points);
  add_grid({0, 3.1, 0}, {0, 5, 1.5}, 0.2, points);  // 1.1 m from the first one
  const auto second = std::ssize(points);
  add_grid({8, -20, 0}, {8, 20, 4}, 0.2, points);     // a wall
  add_grid({4, 0, 0}, {4, 4, 0.3}, 0.2, points);      // a kerb
  add_grid({20, 0, 0}, {20, 0.4, 0.6}, 0.3, points);  // too few points
  const auto clusters = clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.3}, {});
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_EQ(std::ssize(clusters[0]), first);
  EXPECT_EQ(std::ssize(clusters[1]), second - first);
  EXPECT_EQ(clusters[1].front(), first);
  LidarClusterOptions wide;
  wide.tolerance_m = 1.8;
  EXPECT_EQ(clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.3}, wide).size(), 1u);
  // what hangs in the air stands on no ground
  EXPECT_EQ(clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.6}, {}).size(), 0u);
}

// 2 degrees apart, as a VLP-16's: 1.4 m at 40 m.
TEST(LidarClusters, RowsOfASpinningLidarHangTogetherOnABody) {
  const double gap_rad = 2 * std::numbers::pi / 180;
  RandomStream random(1, "test");
  std::vector<Vector3d> points;
  std::vector<double> elevations_rad, rises_m;
  for (int row = -8; row < 8; ++row)
    for (int i = 0; i < 400; ++i) {
      elevations_rad.push_back(gap_rad * (row + 0.025 * random.normal()));
      const double range_m = 40, across_m = 0.14 * (i % 15), up_m = range_m * elevations_rad.back();
      points.emplace_back(range_m, (i % 2 ? 0 : 5) + across_m, up_m);  // two of them, 3 m apart
    }
  const std::vector<double> gaps = row_gaps(elevations_rad);
  for (const double gap : gaps) {
    EXPECT_NEAR(gap, gap_rad, 0.1 * gap_rad);
    rises_m.push_back(40 * gap);
  }
  LidarClusterOptions options;
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options).size(), 0u);  // each row is too low
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options, {rises_m, {}}).size(), 2u);
  options.max_rise_m = 1;  // each row is a body of its own, which may be as high as the next row is away
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options, {rises_m, {}}).size(), 32u);
  // A rosette, of which few beams go beyond its rim.
  for (double& elevation : elevations_rad) elevation = random.uniform(-0.5, 0.5);
  for (int i = 0; i < 20; ++i) elevations_rad[i] = 0.52 + 0.0002 * random.normal();
  for (const double gap : row_gaps(elevations_rad)) EXPECT_EQ(gap, 0);
}

// The side of a truck 40 m ahead, 8 m beside the way: beams 0.2 degrees apart meet it every 0.7 to 0.9 m.
TEST(LidarClusters, ASideThatIsMetAtAGrazingAngleHangsTogether) {
  const double step_rad = 0.2 * std::numbers::pi / 180;
  std::vector<Vector3d> points;
  std::vector<double> azimuths_rad, elevations_rad, steps_m;
  for (int row = 0; row < 5; ++row)
    for (double azimuth = std::atan2(8, 46); azimuth < std::atan2(8, 36); azimuth += step_rad) {
      points.emplace_back(8 / std::tan(azimuth), 8, 0.3 * row);
      azimuths_rad.push_back(azimuth);
      elevations_rad.push_back(0.007 * row);
      steps_m.push_back(step_rad * points.back().norm());
    }
  EXPECT_NEAR(beam_step(azimuths_rad, elevations_rad), step_rad, 1e-9);
  const auto apart = clusters_above(matrix_of(points), {}, {});
  ASSERT_FALSE(apart.empty());
  EXPECT_LT(apart[0].size(), points.size() - 10);
  const auto together = clusters_above(matrix_of(points), {}, {}, {{}, steps_m});
  ASSERT_EQ(together.size(), 1u);
  EXPECT_EQ(together[0].size(), points.size());
}

// Places that no integer counts are cells like others.
TEST(LidarClusters, PointsOfNoPlaceLeaveTheOthersAsTheyAre) {
  std::vector<Vector3d> points;
  add_grid({-20, -20, 0}, {20, 20, 0}, 0.5, points);
  add_grid({0, 0, 0.3}, {0, 2, 1.5}, 0.2, points);
  const auto good = std::ssize(points);
  const auto body = [&] {
    const Eigen::Matrix3Xd all = matrix_of(points);
    return clusters_above(all, find_ground(all, {}, 3, 0), {});
  };
  const auto expected = body();
  ASSERT_EQ(expected.size(), 1u);
  for (const double far : {1e12, -1e12})  // their mean would be in the body's middle
    points.insert(points.end(), 20, Vector3d(far, 0, 1));
  EXPECT_EQ(body(), expected);
  EXPECT_LT(expected[0].back(), good);
}

ClusterBox box_at(double x, double y, double length_m = 4, double width_m = 2) {
  return {{x - length_m / 2, y - width_m / 2, 0}, {x + length_m / 2, y + width_m / 2, 1.5}, {}};
}

std::int64_t stamp(int scan) {
  return 100'000'000 * std::int64_t{scan};
}

TEST(ClusterTracker, BodiesKeepTheirIdsAndVelocitiesAsTheyPass) {
  ClusterTracker tracker{{}};
  std::array<int, 2> ids{};
  for (int i = 0; i < 40; ++i) {
    const double t = 0.1 * i;
    std::vector<ClusterBox> boxes = {box_at(5 * t, 0), box_at(20 - 8 * t, 3)};
    if (i % 2) std::swap(boxes[0], boxes[1]);  // no order is promised
    const bool hidden = i > 20 && i < 25;      // the second one
    if (hidden) boxes.erase(boxes.begin() + (i % 2 ? 0 : 1));
    const auto tracked = tracker.track(stamp(i), boxes);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      const int which = boxes[k].low.y() < 0 ? 0 : 1;
      if (i == 0) ids[which] = tracked[k].id;
      EXPECT_EQ(tracked[k].id, ids[which]) << i;
      EXPECT_EQ(tracked[k].seen_as_body > 0, i >= 6) << i;
      if (i >= 2) {
        EXPECT_NEAR(tracked[k].velocity_mps.x(), which ? -8 : 5, 1e-9);
        EXPECT_NEAR(tracked[k].velocity_mps.y(), 0, 1e-9);
      }
    }
  }
}

TEST(ClusterTracker, WhatIsUncoveredOrStandsIsNoBody) {
  ClusterTracker tracker{{}};
  for (int i = 0; i < 20; ++i) {
    const double t = 0.1 * i;
    ClusterBox uncovered = box_at(0, 0), entering = box_at(20, 0);
    uncovered.high.x() += 2 * t;  // one end stays, a shadow's goes
    entering.high.x() += 2 * t;   // one end is that of the view: the other one tells
    entering.cut = {true, false, false, false};
    const auto tracked = tracker.track(stamp(i), {uncovered, entering, box_at(40, 0)});
    for (const TrackedCluster& cluster : tracked) EXPECT_EQ(cluster.seen_as_body, 0);
    if (i < 2) continue;
    EXPECT_NEAR(tracked[1].velocity_mps.x(), 2, 1e-9);
  }
  ClusterTrackerOptions all;
  all.moving_only = false;
  ClusterTracker any{all};
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(any.track(stamp(i), {box_at(40, 0)})[0].seen_as_body, std::max(0, i - 3));
}

// Of a car that is overtaken the far end is where the rows of the LiDAR last met its roof.
TEST(ClusterTracker, WhatShowsOneEndMovesWithIt) {
  ClusterTracker tracker{{}};
  RandomStream random(2, "test");
  int first_body = 0;
  for (int i = 0; i < 20; ++i) {
    ClusterBox box = box_at(20 + 0.8 * i, 0);
    box.high.x() = box.low.x() + random.uniform(0.5, 4);
    box.hidden[1] = true;
    ClusterBox still = box_at(20, 10);
    still.high.x() = still.low.x() + random.uniform(0.5, 4);
    still.low.x() += 0.1 * random.normal();
    still.hidden[1] = true;
    const auto tracked = tracker.track(stamp(i), {box, still});
    if (tracked[0].seen_as_body > 0 && first_body == 0) first_body = i;
    EXPECT_EQ(tracked[1].seen_as_body, 0) << i;
    if (i >= 2) {
      EXPECT_NEAR(tracked[0].velocity_mps.x(), 8, 1e-9) << i;
    }
  }
  EXPECT_GE(first_body, 4);
  EXPECT_LE(first_body, 8);
}

// Ends that were seen early and late in a scan by turns.
TEST(ClusterTracker, EndsAreWhereTheyWereAtTheirOwnTime) {
  ClusterTracker tracker{{}};
  for (int i = 0; i < 10; ++i) {
    const double ago_s = i % 2 ? 0.1 : 0;
    ClusterBox box = box_at(5 + 8 * (0.1 * i - ago_s), 0);
    box.ago_s = {ago_s, ago_s, ago_s, ago_s};
    const auto tracked = tracker.track(stamp(i), {box});
    if (i >= 2) {
      EXPECT_NEAR(tracked[0].velocity_mps.x(), 8, 1e-9) << i;
    }
  }
}

// The front of a car alone, 2.5 m nearer with each scan, among others that stand.
TEST(ClusterTracker, WhatIsFasterThanItIsLongIsFollowed) {
  ClusterTracker tracker{{}};
  const auto boxes = [](int i) {
    ClusterBox front = box_at(60 - 2.5 * i, 0, 0.4, 1.8);
    front.hidden[1] = true;
    return std::vector{box_at(60, 4), front, box_at(50, -4), box_at(40, 5)};
  };
  int id = 0;
  for (int i = 0; i < 12; ++i) {
    const auto tracked = tracker.track(stamp(i), boxes(i));
    if (i == 0) id = tracked[1].id;
    EXPECT_EQ(tracked[1].id, id) << i;
    EXPECT_EQ(tracked[1].seen_as_body > 0, i >= 6) << i;
    if (i > 0) {
      EXPECT_NEAR(tracked[1].velocity_mps.x(), -25, 1e-9) << i;
    }
    for (const int other : {0, 2, 3}) EXPECT_EQ(tracked[other].seen_as_body, 0);
  }
}

}  // namespace
}  // namespace uniquadric
