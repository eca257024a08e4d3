#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <numbers>

#include "core/base/files.h"
#include "estimator/ego/lidar_registration.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

fs::path data_folder() {
  const char* given = std::getenv("UNIQUADRIC_DATA");
  return fs::path(given ? given : UNIQUADRIC_SOURCE_DIR "/../shared/data") / "lidar_pair";
}

// Little-endian x y z intensity, as these files have it.
std::vector<TimedPoint> read_ply(const fs::path& path) {
  const std::string text = read_text(path), end = "end_header\n";
  const std::size_t data = text.find(end) + end.size();
  std::vector<TimedPoint> points((text.size() - data) / 16);
  for (std::size_t i = 0; i < points.size(); ++i)
    std::memcpy(points[i].lidar.data(), text.data() + data + 16 * i, 12);
  return points;
}

Pose read_transform(const fs::path& path) {
  std::ifstream file(path);
  Eigen::Matrix4d T;
  for (int i = 0; i < 16; ++i) file >> T(i / 4, i % 4);
  return {Eigen::Quaterniond(Eigen::Matrix3d(T.topLeftCorner<3, 3>())).normalized(),
          T.topRightCorner<3, 1>()};
}

// Two real scans half a metre apart, registered from no knowledge of it. Place and the other two angles meet
// the reference within 1 cm and 0.02 deg; about x our planes say 0.23 deg more than it. The pair does not
// tell that angle better: point-to-plane ICP of all points (PCL), begun at the reference, leaves it by -0.28
// to 0.26 deg about x (20 neighbours a normal, gates of 0.1 to 1 m: 0.17 to 0.26); generalised ICP (PCL,
// leaves of 0.1 to 0.5 m, 10 or 20 neighbours, gates of 0.5 to 2 m) says -0.14 to 0.66 deg.
constexpr double kShiftTolerance_m = 0.02;
constexpr double kTurnTolerance_rad = 0.3 * std::numbers::pi / 180;

TEST(LidarPair, RegistersTwoRealScans) {
  if (!fs::exists(data_folder())) GTEST_SKIP() << data_folder() << " is not there";
  const auto target = read_ply(data_folder() / "target.ply"), source = read_ply(data_folder() / "source.ply");
  ASSERT_EQ(target.size(), 69088U);
  const Pose truth = read_transform(data_folder() / "T_target_source.txt");
  LidarMapOptions map_options;
  map_options.cell_m = 0.12;
  map_options.levels = 3;
  LidarMap map(map_options);
  for (const TimedPoint& p : target) map.add(p.lidar.cast<double>(), elevation_rad(p.lidar));
  LidarBelief belief;
  Vector18d sigma = Vector18d::Zero();
  sigma.segment<3>(kTurn).setConstant(0.1);
  sigma.segment<3>(kPlace).setConstant(1);
  belief.covariance = sigma.cwiseAbs2().asDiagonal();
  LidarSightOptions options;
  options.max_thickness = 2;  // a single scan's cells hold few points
  options.searches = 100;
  options.open_gate_m = 1;
  const SweepPath path(belief.state, {});
  for (const int first_iteration : {0, 2}) {  // with the wide gate first, then with the narrow one
    LidarRegistration registration(map, source, path, Pose(), 0.25, belief.covariance,
                                   point_sigmas(options, {}), 0, options);
    const auto normal_at = [&](const LidarState& state, int i) {
      return registration.normal_at(state, first_iteration == 0 ? 0 : first_iteration + i);
    };
    belief.state = updated(belief, normal_at, 50).state;
    EXPECT_GT(registration.on_planes(), 2000);
  }
  const Pose& pose = belief.state.world_from_body;
  EXPECT_LT((pose.translation - truth.translation).norm(), kShiftTolerance_m);
  EXPECT_LT(log_so3(pose.rotation.conjugate() * truth.rotation).norm(), kTurnTolerance_rad);
}

}  // namespace
}  // namespace uniquadric
