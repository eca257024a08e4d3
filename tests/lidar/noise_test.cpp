#include <gtest/gtest.h>

#include <cmath>

#include "simulator/lidar/echoes.h"
#include "simulator/noise/normals.h"
#include "simulator/scene/named_motions.h"
#include "tests/lidar/lidar_support.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kSigmas = 5;  // of a statistic's own spread: passes all but one run in a million

PoseAt at_rest() {
  return [](double) { return Pose{}; };
}

Body wall(double distance_m, float reflectivity = 0.5f, double yaw_deg = 0, double side_m = 200) {
  const Pose pose{Eigen::Quaterniond(Eigen::AngleAxisd(yaw_deg * kDegree, Vector3d::UnitZ())),
                  Vector3d(distance_m, 0, 0)};
  return body(1, square(side_m), static_motion(pose), reflectivity);
}

// Facets of a sphere so fine that every range is the radius to a part in 1e5.
Body shell(double radius_m, float reflectivity) {
  return body(1, sphere(radius_m, 400), Motion(), reflectivity);
}

LidarRig noisy_rig(const char* pattern) {
  LidarRig rig;
  rig.pattern = named_pattern(pattern);
  rig.noise = noise_of(pattern);
  rig.noise.false_alarm = rig.noise.detection_sigma = rig.noise.r10_m = 0;
  return rig;
}

double measured_range(const LidarPoint& p) {
  return Vector3d(p.x, p.y, p.z).norm();
}

TEST(LidarNoise, RangeResidualsHaveTheVarianceOfRangeAndIncidence) {
  LidarRig rig = noisy_rig("livox_avia");
  const RayCaster caster({}, {wall(20, 0.5f, 30)});
  std::vector<double> sums(8, 0), counts(8, 0);  // by incidence, ten degrees each
  double sum = 0, mean = 0, n = 0, largest_sigma = 0;
  for (int scan = 0; scan < 4; ++scan) {
    const LidarScan points = take_scan(caster, rig, at_rest(), scan, 11);
    for (std::size_t i = 0; i < points.points.size(); ++i) {
      const LidarPointTruth& truth = points.truth[i];
      const double gamma = 0.28 * kDegree, r = truth.range_m, theta = std::acos(double{truth.incidence_cos});
      const double variance =
          0.02 * 0.02 + std::pow(r * gamma * std::tan(theta), 2) / 12 + 1e-6 / 12;  // 1 mm steps
      const double residual = measured_range(points.points[i]) - r;
      const auto bin = std::min(sums.size() - 1, static_cast<std::size_t>(theta / kDegree / 10));
      sums[bin] += residual * residual / variance;
      sum += residual * residual / variance;
      mean += residual / std::sqrt(variance);
      largest_sigma = std::max(largest_sigma, std::sqrt(variance));
      ++counts[bin];
      ++n;
    }
  }
  ASSERT_GT(n, 80'000);
  EXPECT_GT(largest_sigma, 0.06);  // the incidence term shows
  EXPECT_NEAR(sum / n, 1, kSigmas * std::sqrt(2 / n));
  EXPECT_NEAR(mean / n, 0, kSigmas * std::sqrt(1 / n));
  int bins = 0;
  for (std::size_t k = 0; k < sums.size(); ++k) {
    if (counts[k] < 500) continue;
    EXPECT_NEAR(sums[k] / counts[k], 1, kSigmas * std::sqrt(2 / counts[k])) << 10 * k << " deg";
    ++bins;
  }
  EXPECT_GE(bins, 5);
}

TEST(LidarNoise, ABeamsDrawsDependOnItsNumberAlone) {
  BeamDraws all, some, other;
  draw_beams(5, 3, 0, 256, all);
  for (const int first : {1, 63, 64, 100}) {
    draw_beams(5, 3, static_cast<std::uint32_t>(first), 70, some);
    for (int i = 0; i < 70; ++i) {
      EXPECT_EQ(some.range[i], all.range[first + i]);
      EXPECT_EQ(some.detection[i], all.detection[first + i]);
      EXPECT_EQ(some.aim_horizontal[i], all.aim_horizontal[first + i]);
      EXPECT_EQ(some.aim_vertical[i], all.aim_vertical[first + i]);
    }
  }
  draw_beams(5, 4, 0, 256, other);
  EXPECT_NE(all.range[0], other.range[0]);
}

TEST(LidarNoise, RangesAreMultiplesOfAMillimetre) {
  LidarRig rig = noisy_rig("livox_avia");
  const LidarScan scan = take_scan(RayCaster({}, {wall(5)}), rig, at_rest(), 0, 1);
  for (const LidarPoint& p : scan.points) {
    const double mm = measured_range(p) * 1e3;
    ASSERT_NEAR(mm, std::round(mm), 5e-3);  // the point's coordinates are single precision
  }
}

TEST(LidarNoise, BeamsPointElsewhereByTheAngleAskedFor) {
  LidarRig rig = noisy_rig("livox_mid40");
  rig.noise = LidarNoise::none();
  rig.noise.angle_sigma_deg = 0.1;
  constexpr double kDistance_m = 30, kYaw_deg = 45;
  // On a wall at 45 deg a beam that points by a to the side changes its range by r a, to first order.
  const LidarScan scan = take_scan(RayCaster({}, {wall(kDistance_m, 0.5f, kYaw_deg)}), rig, at_rest(), 0, 3);
  const Vector3d normal(std::cos(kYaw_deg * kDegree), std::sin(kYaw_deg * kDegree), 0);
  double sum = 0, n = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i) {
    const LidarPoint& p = scan.points[i];
    const Vector3d reported = Vector3d(p.x, p.y, p.z).normalized();
    const double nominal = kDistance_m * normal.x() / normal.dot(reported);
    const Vector3d left = Vector3d::UnitZ().cross(reported).normalized(), up = reported.cross(left);
    const double slope = std::hypot(normal.dot(left), normal.dot(up)) / normal.dot(reported);
    sum += std::pow((scan.truth[i].range_m - nominal) / (nominal * slope * 0.1 * kDegree), 2);
    ++n;
  }
  ASSERT_GT(n, 9'000);
  EXPECT_NEAR(sum / n, 1, kSigmas * std::sqrt(2 / n) + 0.001);  // plus the second order
}

TEST(LidarNoise, HalfTheBeamsReturnAtR10) {
  LidarRig rig = noisy_rig("livox_mid40");
  rig.noise = LidarNoise::none();
  rig.noise.r10_m = 20;
  rig.noise.detection_sigma = 0.1;
  int compared = 0;
  for (const double radius : {18.0, 19.0, 20.0, 20.5, 22.0}) {
    const LidarScan scan = take_scan(RayCaster({}, {shell(radius, 0.1f)}), rig, at_rest(), 0, 8);
    const double expected = normal_cdf((std::pow(20 / radius, 2) - 1) / 0.1);
    const double n = static_cast<double>(scan.beams);
    const double found = static_cast<double>(scan.points.size()) / n;
    // 2e-4: the facets lie a little inside the sphere.
    EXPECT_NEAR(found, expected, kSigmas * std::sqrt(expected * (1 - expected) / n) + 2e-4) << radius;
    if (radius == 20) {
      EXPECT_NEAR(expected, 0.5, 1e-12);
    }
    ++compared;
  }
  EXPECT_EQ(compared, 5);
}

TEST(LidarNoise, HazeAndObliqueSurfacesWeakenThePulse) {
  LidarNoise noise;
  noise.r10_m = 100;
  const double limit = detection_limit(noise);
  EXPECT_NEAR(received_strength(noise, 100, 0.1) / limit, 1, 1e-12);
  EXPECT_NEAR(received_strength(noise, 50, 0.1) / limit, 4, 1e-12);
  EXPECT_NEAR(received_strength(noise, 100, 0.8 * std::cos(60 * kDegree)) / limit, 4, 1e-12);
  noise.extinction_per_m = 0.01;
  EXPECT_NEAR(received_strength(noise, 100, 0.1) / limit, std::exp(-2), 1e-12);
}

TEST(LidarNoise, FalseAlarmsComeAtTheirRate) {
  LidarRig rig = noisy_rig("livox_avia");
  rig.noise.false_alarm = 0.01;
  double found = 0, n = 0, sum_m = 0;
  for (int scan = 0; scan < 5; ++scan) {
    const LidarScan points = take_scan(RayCaster({}, {wall(10, 0.5f, 0, 0.1)}), rig, at_rest(), scan, 2);
    for (const LidarPointTruth& truth : points.truth)
      if (truth.kind == LidarPointTruth::Kind::false_alarm) {
        ++found;
        sum_m += truth.range_m;
      }
    n += static_cast<double>(points.beams);
  }
  EXPECT_NEAR(found / n, 0.01, kSigmas * std::sqrt(0.01 * 0.99 / n));
  const double span = rig.noise.max_range_m - rig.noise.min_range_m;
  EXPECT_NEAR(sum_m / found, rig.noise.min_range_m + span / 2, kSigmas * span / std::sqrt(12 * found));
}

TEST(LidarNoise, WeakEchoesAreBiased) {
  LidarRig rig = exact_rig(named_pattern("livox_mid40"));
  rig.noise.weak_bias_m = 0.04;
  for (const float reflectivity : {0.25f, 1.0f}) {
    const LidarScan scan = take_scan(RayCaster({}, {wall(10, reflectivity)}), rig, at_rest(), 0, 0);
    for (std::size_t i = 0; i < scan.points.size(); i += 97) {
      const double reflected = reflectivity * double{scan.truth[i].incidence_cos};
      ASSERT_NEAR(measured_range(scan.points[i]) - scan.truth[i].range_m, 0.04 * (1 - reflected), 1e-4);
    }
  }
}

TEST(LidarNoise, CrosstalkShowsTheEchoOfTheBeamBefore) {
  LidarRig rig = exact_rig(named_pattern("vlp16"));
  rig.noise.crosstalk = 0.02;
  const RayCaster shells({}, {shell(12, 0.5f)});
  const LidarScan scan = take_scan(shells, rig, at_rest(), 0, 3);
  double ghosts = 0;
  for (std::size_t i = 0; i < scan.points.size(); ++i)
    if (scan.truth[i].kind == LidarPointTruth::Kind::false_alarm) {
      ++ghosts;
      ASSERT_NEAR(measured_range(scan.points[i]), 12, 1e-3);  // as far as the beam before it
    }
  const double n = static_cast<double>(scan.beams);
  EXPECT_NEAR(ghosts / n, 0.02,
              kSigmas * std::sqrt(0.02 * 0.98 / n) + 0.02 / 64);  // a block's first has none before
}

TEST(LidarNoise, IntensityTellsDiffuseFromRetroReflecting) {
  EXPECT_EQ(reported_intensity(0), 0);
  EXPECT_EQ(reported_intensity(0.5), 75);
  EXPECT_EQ(reported_intensity(1), 150);
  EXPECT_EQ(reported_intensity(1.001), 151);
  EXPECT_EQ(reported_intensity(1000), 255);
  LidarRig rig = exact_rig(named_pattern("livox_mid40"));
  const RayCaster named({}, {wall(10, 0.5f, 60)}, {}, {{"body1", 10.0}});
  for (const LidarPoint& p : take_scan(named, rig, at_rest(), 0, 0).points) ASSERT_EQ(p.intensity, 203);
  for (const LidarPoint& p : take_scan(RayCaster({}, {wall(10, 0.4f)}), rig, at_rest(), 0, 0).points) {
    const double cosine = p.x / measured_range(p);
    ASSERT_NEAR(p.intensity, 150 * 0.4 * cosine, 0.5 + 1e-3);
  }
}

TEST(LidarBeam, ReportsFirstStrongestOrLastOfSeveralSurfaces) {
  LidarNoise noise = LidarNoise::none();
  LidarBeam beam;
  const auto report = [&](LidarBeam::Return returned, double limit = 1e-5) {
    std::vector<RayReturn> rays = {{30, 0.3, 1, 3}, {10, 0.02, 1, 1}, {20, 0.2, 1, 2}, {30.4, 0.1, 1, 4}};
    beam.returned = returned;
    return reported_echo(rays, beam, noise, limit);
  };
  const auto first = report(LidarBeam::Return::first), strongest = report(LidarBeam::Return::strongest),
             last = report(LidarBeam::Return::last);
  ASSERT_TRUE(first && strongest && last);
  EXPECT_EQ(first->range_m, 10);
  EXPECT_EQ(first->number, 0);
  EXPECT_EQ(strongest->range_m, 20);  // 0.2 / 20^2 is more than both of 0.3 / 30^2 + 0.1 / 30.4^2
  EXPECT_EQ(strongest->instance, 2);
  EXPECT_EQ(strongest->number, 1);
  // Two surfaces within 0.6 m are one echo, where their strengths balance.
  const double a = 0.3 / (30.0 * 30), b = 0.1 / (30.4 * 30.4);
  EXPECT_NEAR(last->range_m, (a * 30 + b * 30.4) / (a + b), 1e-12);
  EXPECT_TRUE(last->mixed);
  EXPECT_EQ(last->instance, 3);
  EXPECT_FALSE(report(LidarBeam::Return::first, 1e-2));
  // What is too weak counts as no echo.
  EXPECT_EQ(report(LidarBeam::Return::first, 2.5e-4)->range_m, 20);
}

TEST(LidarBeam, MixesSurfacesAtAnEdge) {
  LidarRig rig = exact_rig(square_pattern(120, 6, 0.1));
  rig.beam.horizontal_deg = 0.5;
  rig.beam.horizontal_rays = 8;
  rig.beam.vertical_rays = 2;
  // The near wall, to the left of x, ends where the far one shows.
  const Body near = body(2, square(10), static_motion({Eigen::Quaterniond::Identity(), {20, 5, 0}}));
  const auto kinds = [&](double far_m, LidarBeam::Return returned) {
    rig.beam.returned = returned;
    const LidarScan scan = take_scan(RayCaster({}, {near, wall(far_m)}), rig, at_rest(), 0, 0);
    EXPECT_EQ(scan.points.size(), static_cast<std::size_t>(scan.beams));
    std::array<int, 3> count{};  // near, between, far
    for (const LidarPoint& p : scan.points) ++count[p.x < 20.02 ? 0 : p.x < far_m - 0.02 ? 1 : 2];
    return count;
  };
  const auto close = kinds(20.4, LidarBeam::Return::strongest);
  EXPECT_GT(close[1], 120 * 5);  // ten beams of a row see both walls
  const auto first = kinds(25, LidarBeam::Return::first), last = kinds(25, LidarBeam::Return::last);
  EXPECT_EQ(first[1], 0);
  EXPECT_EQ(last[1], 0);
  // Beams are 0.05 deg apart and 0.5 deg wide with rays at 1/16, 3/16 ...: those within 7/16 of the width see
  // both.
  EXPECT_NEAR(first[0] - last[0], 120 * 0.4375 / 0.05, 120 * 1.5);
}

}  // namespace
}  // namespace uniquadric
