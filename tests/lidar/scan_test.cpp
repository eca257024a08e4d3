#include <gtest/gtest.h>

#include <cmath>

#include "simulator/scene/named_motions.h"
#include "simulator/scene/shapes.h"
#include "tests/lidar/lidar_support.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

// Single precision at 50 m: half a unit in the last place is 2e-6 m of range and as much of each vertex.
constexpr double kRangeTolerance_m = 2e-5;

Motion line(const Vector3d& from, const Vector3d& velocity) {
  return line_motion({Eigen::Quaterniond::Identity(), from}, velocity);
}

// Moves along `velocity` and turns about an axis of its own.
Motion tumbling(const Vector3d& from, const Vector3d& velocity, double rate_radps) {
  ScrewOptions spin;
  spin.axis = Vector3d(1, 2, 3).normalized();
  spin.rate_radps = rate_radps;
  return composed_motion({line(from, velocity), screw_motion(spin)});
}

// A handheld sensor: swings, turns and travels.
Motion sensor_motion(const Vector3d& from) {
  SwingOptions swing;
  swing.pivot_m = from + Vector3d(0, 0, 1);
  swing.axis = Vector3d::UnitY();
  swing.amplitude_rad = 0.3;
  swing.period_s = 1.7;
  return composed_motion({line(Vector3d::Zero(), {3, -2, 0.5}), swing_motion(swing)});
}

struct RayInWorld {
  Vector3d origin, direction;
};

RayInWorld ray_of(const LidarRig& rig, const Motion& sensor, const LidarScan& scan, std::size_t i) {
  const std::int64_t time_ns = scan.start_ns + scan.points[i].offset_ns;
  const Pose pose = path_at(sensor, time_ns);
  const Beam beam = beam_at(rig.pattern, time_ns);
  return {pose * beam.origin, pose.rotation * beam.direction};
}

PoseAt path(const Motion& motion) {
  return [motion](double time_s) { return motion.at(time_s); };
}

TEST(LidarScan, PlaneMovingAlongItsNormalMeetsTheClosedForm) {
  const Vector3d start(50, 0, 1), velocity(-20, 0, 0);
  const Motion plane = line(start, velocity), sensor = sensor_motion({0, 0, 1});
  const LidarRig rig = exact_rig(named_pattern("livox_avia"));
  const RayCaster caster({}, {body(7, square(300), plane)});
  const LidarScan scan = take_scan(caster, rig, path(sensor), 3, 0);
  ASSERT_EQ(scan.points.size(), static_cast<std::size_t>(scan.beams));
  ASSERT_EQ(scan.beams, 24'000);
  double farthest = 0;
  std::vector<double> errors;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const RayInWorld ray = ray_of(rig, sensor, scan, i);
    const double time_s = static_cast<double>(scan.start_ns + scan.points[i].offset_ns) * 1e-9;
    const double range = (start.x() + velocity.x() * time_s - ray.origin.x()) / ray.direction.x();
    ASSERT_EQ(scan.truth[i].instance, 7);
    ASSERT_NEAR(scan.truth[i].incidence_cos, ray.direction.x(), 1e-5);
    const LidarPoint& p = scan.points[i];
    ASSERT_NEAR(Vector3d(p.x, p.y, p.z).norm(), scan.truth[i].range_m, 1e-5);
    errors.push_back(std::abs(range - static_cast<double>(scan.truth[i].range_m)));
    ASSERT_LT(errors.back(), kRangeTolerance_m * std::max(1.0, range / 50)) << range;
    farthest = std::max(farthest, range);
  }
  std::sort(errors.begin(), errors.end());
  RecordProperty("median_um", std::to_string(1e6 * errors[errors.size() / 2]));
  RecordProperty("percentile99_um", std::to_string(1e6 * errors[errors.size() * 99 / 100]));
  EXPECT_GT(farthest, 50);
}

// Ranges against the sphere's quadratic, for hits under 60 degrees of incidence (beyond, the facets' distance
// from the sphere and the rounding of the direction count several times).
void expect_sphere(const Motion& centre, const Motion& sensor) {
  constexpr double kRadius_m = 0.5;
  constexpr int kSegments = 1000;  // facets lie within 2.5e-6 m of the sphere
  const LidarRig rig = exact_rig(square_pattern(100, 3, 0.1));
  const RayCaster caster({}, {body(3, sphere(kRadius_m, kSegments), centre)});
  const LidarScan scan = take_scan(caster, rig, path(sensor), 0, 0);
  int compared = 0;
  double worst = 0, farthest = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    if (scan.truth[i].incidence_cos < 0.5f) continue;
    const RayInWorld ray = ray_of(rig, sensor, scan, i);
    const Vector3d to_centre = path_at(centre, scan.points[i].offset_ns).translation - ray.origin;
    const double along = to_centre.dot(ray.direction);
    const double across2 = (to_centre - along * ray.direction).squaredNorm();
    const double range = along - std::sqrt(kRadius_m * kRadius_m - across2);
    worst = std::max(worst, std::abs(range - static_cast<double>(scan.truth[i].range_m)));
    farthest = std::max(farthest, range);
    ++compared;
  }
  EXPECT_GT(compared, 300);
  EXPECT_GT(farthest, 45);
  EXPECT_LT(worst, kRangeTolerance_m);
}

TEST(LidarScan, SpinningSphereSeenByAMovingSensorMeetsTheClosedForm) {
  expect_sphere(tumbling({50, 0, 0}, {-15, 2, 1}, 20), tumbling({0, 0, 0}, {3, -2, 0.5}, 0.1));
}

TEST(LidarScan, CurvedMotionIsMetByAsManyKeysAsItTakes) {
  SwingOptions swing;
  swing.pivot_m = {49, 0, 1};
  swing.period_s = 1;
  swing.phase_rad = 1;
  expect_sphere(swing_motion(swing), tumbling({0, 0, 0}, {1, 0, 0}, 0.05));
}

TEST(MotionKeys, FollowTheMeasuredError) {
  const std::int64_t end = 100'000'000;
  EXPECT_EQ(motion_keys_for(Motion(), 0, end, 1, 1e-6).count, 1);
  const MotionKeys straight = motion_keys_for(line({0, 0, 0}, {10, 0, 0}), 0, end, 1, 1e-6);
  EXPECT_EQ(straight.count, 2);
  const MotionKeys tumble = motion_keys_for(tumbling({0, 0, 0}, {10, 0, 0}, 5), 0, end, 1, 1e-6);
  EXPECT_EQ(tumble.count, 2);
  EXPECT_TRUE(tumble.slerp);
  // A circle of radius r at rate w: n chords of a scan of T lie within r (w T / n)^2 / 8 of it.
  CircleOptions circle;
  circle.radius_m = 2;
  circle.rate_radps = 3;
  const MotionKeys curved = motion_keys_for(circle_motion(circle), 0, end, 0, 1e-5);
  EXPECT_EQ(curved.count, 1 + static_cast<int>(std::ceil(std::sqrt(2 * 0.3 * 0.3 / 8 / 1e-5))));
}

TEST(SensorPath, CubicsMeetTheMotion) {
  const Motion sensor = sensor_motion({1000, -200, 3});
  const SensorPath cubics(path(sensor), 200'000'000, 300'000'000);
  EXPECT_LT((cubics.origin() - sensor.at(0.2).translation).norm(), 1e-3);
  const ScanPattern pattern = named_pattern("os1_64");
  BeamBlock beams;
  WorldRays rays;
  const std::int64_t end = pattern.first_at(300'000'000);
  int compared = 0;
  for (std::int64_t first = pattern.first_at(200'000'000); first + 200 < end; first += 200) {
    pattern.fill(first, 200, beams);
    cubics.place(beams, rays);
    for (int i = 0; i < beams.count; i += 50, ++compared) {
      const Pose pose = path_at(sensor, beams.time_ns[i]);
      const Vector3d direction = pose.rotation * Vector3d(beams.x[i], beams.y[i], beams.z[i]);
      const Vector3d origin =
          pose * Vector3d(beams.origin_x[i], beams.origin_y[i], beams.origin_z[i]) - cubics.origin();
      ASSERT_LT((direction - Vector3d(rays.x[i], rays.y[i], rays.z[i])).norm(), 1e-10);
      ASSERT_LT((origin - Vector3d(rays.origin_x[i], rays.origin_y[i], rays.origin_z[i])).norm(), 1e-10);
    }
  }
  EXPECT_GT(compared, 1000);
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a);
  const Vector3d corners[] = {a, b, c};
  bool inside = true;
  double nearest = 1e9;
  for (int k = 0; k < 3; ++k) {
    const Vector3d& from = corners[k];
    const Vector3d edge = corners[(k + 1) % 3] - from;
    inside = inside && n.cross(edge).dot(p - from) >= 0;
    const double u = std::clamp((p - from).dot(edge) / edge.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - from - u * edge).norm());
  }
  return inside ? std::abs(n.dot(p - a)) / n.norm() : nearest;
}

double distance_to_mesh(const Vector3d& p, const std::vector<Mesh>& meshes) {
  double nearest = 1e9;
  for (const Mesh& mesh : meshes)
    for (const auto& t : mesh.triangles)
      nearest = std::min(nearest, distance_to_triangle(p, mesh.positions[t[0]].cast<double>(),
                                                       mesh.positions[t[1]].cast<double>(),
                                                       mesh.positions[t[2]].cast<double>()));
  return nearest;
}

TEST(LidarScan, DeskewingWithTrueMotionPutsPointsOnTheMesh) {
  SwingOptions swing;
  swing.pivot_m = {20, 0, 2};
  swing.axis = Vector3d::UnitX();
  swing.period_s = 1.1;
  swing.phase_rad = 0.7;
  Body box = body(1, {}, composed_motion({swing_motion(swing), tumbling({0, 0, 0}, {0, 0, 0}, 4)}));
  RoundedBoxOptions shape;
  shape.recess_depth_m = 0.1;
  box.meshes = rounded_box({2, 3, 2.5}, shape, {});
  const Motion sensor = sensor_motion({0, 0, 1});
  const LidarRig rig = exact_rig(named_pattern("livox_avia"));
  const LidarScan scan = take_scan(RayCaster({}, {box}), rig, path(sensor), 4, 0);
  std::vector<double> distances;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const std::int64_t time_ns = scan.start_ns + scan.points[i].offset_ns;
    const LidarPoint& p = scan.points[i];
    const Vector3d in_object =
        path_at(box.motion, time_ns).inverse() * (path_at(sensor, time_ns) * Vector3d(p.x, p.y, p.z));
    distances.push_back(distance_to_mesh(in_object, box.meshes));
  }
  ASSERT_GT(distances.size(), 300u);
  std::sort(distances.begin(), distances.end());
  const double median = distances[distances.size() / 2], most = distances[distances.size() * 99 / 100];
  RecordProperty("median_m", std::to_string(median * 1e6) + "e-6");
  RecordProperty("percentile99_m", std::to_string(most * 1e6) + "e-6");
  EXPECT_LT(median, 1e-5);
  EXPECT_LT(most, 1e-4);
}

TEST(LidarScan, SensorMotionAloneLeavesTheObjectsMotion) {
  const Vector3d velocity(-12, 0, 0);
  const Motion plane = line({30, 0, 0}, velocity), sensor = sensor_motion({0, 0, 1});
  const LidarRig rig = exact_rig(named_pattern("livox_mid40"));
  const LidarScan scan = take_scan(RayCaster({}, {body(1, square(100), plane)}), rig, path(sensor), 0, 0);
  ASSERT_GT(scan.points.size(), 9'000u);
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const LidarPoint& p = scan.points[i];
    const Vector3d in_world = path_at(sensor, p.offset_ns) * Vector3d(p.x, p.y, p.z);
    const double grown = velocity.norm() * p.offset_ns * 1e-9;
    ASSERT_NEAR(plane.at(0).translation.x() - in_world.x(), grown, kRangeTolerance_m);
  }
}

TEST(LidarScan, WorldFarFromTheOriginIsAsExact) {
  const Vector3d far(4'000, -2'500, 100);
  const Motion sensor = line(far, {10, 0, 0});
  const LidarRig rig = exact_rig(named_pattern("vlp16"));
  const Vector3d start = far + Vector3d(40, 0, 0);
  const LidarScan scan =
      take_scan(RayCaster({}, {body(1, square(60), line(start, {0, 5, 0}))}), rig, path(sensor), 0, 0);
  ASSERT_GT(scan.points.size(), 1'000u);
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const RayInWorld ray = ray_of(rig, sensor, scan, i);
    if (scan.truth[i].range_m > 50) continue;
    ASSERT_NEAR(scan.truth[i].range_m, (start.x() - ray.origin.x()) / ray.direction.x(), kRangeTolerance_m);
  }
}

TEST(LidarScan, SameBytesForAnyThreadsOtherNoiseForAnotherSeed) {
  const Motion sensor = sensor_motion({0, 0, 1});
  std::vector<Body> objects = {body(1, sphere(2, 64), tumbling({15, 0, 0}, {0, 5, 0}, 3)),
                               body(2, square(4), tumbling({12, 4, 1}, {0, -5, 0}, 2))};
  const RayCaster caster({body(0, square(100), line({40, 0, 0}, {0, 0, 0}))}, objects);
  LidarRig rig;
  const auto scan = [&](std::uint64_t seed, int threads) {
    return take_scan(caster, rig, path(sensor), 2, seed, threads);
  };
  const LidarScan one = scan(5, 1);
  ASSERT_GT(one.points.size(), 20'000u);
  const std::string bytes = bytes_of(one);
  for (const int threads : {1, 2, 0}) EXPECT_TRUE(bytes == bytes_of(scan(5, threads))) << threads;
  EXPECT_FALSE(bytes == bytes_of(scan(6, 1)));
}

TEST(LidarScan, SeedChangesNothingOfTheTruth) {
  const RayCaster caster({body(0, square(100), line({40, 0, 0}, {0, 0, 0}))}, {});
  LidarRig rig;
  rig.noise.angle_sigma_deg = rig.noise.false_alarm = rig.noise.detection_sigma = 0;
  const LidarScan a = take_scan(caster, rig, path(Motion()), 0, 1),
                  b = take_scan(caster, rig, path(Motion()), 0, 2);
  ASSERT_EQ(a.points.size(), b.points.size());
  int differ = 0;
  for (std::size_t i = 0; i < a.points.size(); ++i) {
    ASSERT_EQ(a.truth[i].range_m, b.truth[i].range_m);
    ASSERT_EQ(a.points[i].offset_ns, b.points[i].offset_ns);
    differ += a.points[i].x != b.points[i].x;
  }
  EXPECT_GT(differ, 20'000);
}

TEST(LidarScan, RefusesAScanWithoutBeams) {
  LidarRig rig = exact_rig(named_pattern("vlp16"));
  rig.rate_hz = 1e7;
  const RayCaster caster({body(0, square(1), Motion())}, {});
  EXPECT_NE(input_error([&] { take_scan(caster, rig, path(Motion()), 1, 0); }).find("no beam"),
            std::string::npos);
}

}  // namespace
}  // namespace uniquadric
