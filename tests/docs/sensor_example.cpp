// The example of docs/add_sensor.md, which quotes it.
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/random.h"
#include "simulator/scene/named_motions.h"

namespace uniquadric {
namespace {

/// A GNSS receiver that the camera carries (section `gnss:` of a scene).
struct GnssRig {
  double rate_hz = 5;
  double sigma_m = 0.5;  // ours: of each coordinate, white
  Eigen::Vector3d antenna_in_camera_m = Eigen::Vector3d::Zero();
};

GnssRig read_gnss(const ConfigNode& node) {
  GnssRig rig;
  rig.rate_hz = node.positive("rate_hz", rig.rate_hz);
  rig.sigma_m = node.get<double>("sigma_m", rig.sigma_m);
  if (rig.sigma_m < 0) node.at("sigma_m").fail("cannot be negative");
  rig.antenna_in_camera_m = node.get<Eigen::Vector3d>("antenna_in_camera_m", rig.antenna_in_camera_m);
  node.refuse_unknown_keys();
  return rig;
}

struct GnssFix {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d position_m;  ///< of the antenna, in the world
};

/// Fixes from 0 s to the last at or before `end_ns`. Each depends on (seed, its number) alone, so that a
/// longer run begins with the same ones, whatever thread makes them.
std::vector<GnssFix> simulate_gnss(const Motion& world_from_camera, const GnssRig& rig, std::int64_t end_ns,
                                   std::uint64_t seed) {
  std::vector<GnssFix> fixes;
  for (std::uint64_t k = 0;; ++k) {
    const std::int64_t stamp_ns = std::llround(static_cast<double>(k) * 1e9 / rig.rate_hz);
    if (stamp_ns > end_ns) return fixes;
    const Pose camera = world_from_camera.at(static_cast<double>(stamp_ns) * 1e-9);
    RandomStream random(seed, "gnss", k);
    const Eigen::Vector3d noise{random.normal(), random.normal(), random.normal()};
    fixes.push_back({stamp_ns, camera * rig.antenna_in_camera_m + rig.sigma_m * noise});
  }
}

const Motion kCircle = circle_motion({.radius_m = 3, .rate_radps = 0.5});

TEST(Gnss, WithoutNoiseItIsWhereTheAntennaIs) {
  const GnssRig rig{.sigma_m = 0, .antenna_in_camera_m = {0, 0, 0.2}};
  const auto fixes = simulate_gnss(kCircle, rig, 2'000'000'000, 1);
  ASSERT_EQ(fixes.size(), 11u);  // 5 Hz, both ends
  for (const GnssFix& fix : fixes) {
    const double angle = 0.5 * static_cast<double>(fix.stamp_ns) * 1e-9;
    EXPECT_LT((fix.position_m - Eigen::Vector3d(3 * std::cos(angle), 3 * std::sin(angle), 0.2)).norm(),
              1e-12);
  }
}

TEST(Gnss, NoiseHasItsSigmaAndALongerRunBeginsWithTheSameFixes) {
  const GnssRig noisy{.rate_hz = 1000}, exact{.rate_hz = 1000, .sigma_m = 0};
  const auto fixes = simulate_gnss(kCircle, noisy, 4'000'000'000, 1);
  const auto truth = simulate_gnss(kCircle, exact, 4'000'000'000, 1);
  const auto start = simulate_gnss(kCircle, noisy, 1'000'000'000, 1);
  double squares = 0;
  for (std::size_t k = 0; k < fixes.size(); ++k)
    squares += (fixes[k].position_m - truth[k].position_m).squaredNorm();
  const double draws = 3 * static_cast<double>(fixes.size());
  EXPECT_NEAR(std::sqrt(squares / draws), 0.5, 4 * 0.5 / std::sqrt(2 * draws));  // 4 standard errors
  for (std::size_t k = 0; k < start.size(); ++k) EXPECT_EQ(start[k].position_m, fixes[k].position_m);
}

TEST(Gnss, AMisspeltKeyIsNamedWithItsLine) {
  try {
    read_gnss(ConfigNode::parse("rate_hz: 10\nsigma: 1\n", "scene.yaml"));
    FAIL() << "was taken";
  } catch (const InputError& error) {
    EXPECT_TRUE(std::string(error.what()).starts_with("scene.yaml:2: unknown key 'sigma'"));
  }
}

}  // namespace
}  // namespace uniquadric
