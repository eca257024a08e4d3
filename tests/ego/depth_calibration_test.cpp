#include "estimator/ego/depth_calibration.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kPixelSigma = 0.15;

// A camera that goes about a table on an arc, and sees what lies on it and behind it with biased depth.
struct Orbit {
  double bias_per_m = 0, depth_share = 0.004, focal_error = 0;
  double own_share = 0;    // of a point's depth, the same in all frames
  double drift_share = 0;  // of all depths, forgotten by a fifth from frame to frame
  std::uint64_t seed = 1;
  int frames = 30;

  EgoMap map(const Camera& camera) const {
    RandomStream random(seed, "orbit");
    std::vector<Eigen::Vector3d> points;
    for (int i = 0; i < 150; ++i)
      points.push_back({random.uniform(-0.8, 0.8), random.uniform(-0.6, 0.6), random.uniform(0.8, 3)});
    Camera lens = camera;
    lens.fx *= 1 + focal_error;
    lens.fy *= 1 + focal_error;
    std::vector<double> own;
    for (std::size_t k = 0; k < points.size(); ++k) own.push_back(own_share * random.normal());
    EgoMap map;
    RandomStream drifting(seed, "drift");
    double drift = 0;
    for (int i = 0; i < frames; ++i) {
      const double angle = 0.6 * i / frames;
      const Pose world_from_camera{Eigen::Quaterniond(Eigen::AngleAxisd(-angle, Eigen::Vector3d::UnitY())),
                                   {1.5 * std::sin(angle), 0, 1.5 * (1 - std::cos(angle))}};
      Keyframe keyframe{i, world_from_camera.inverse(), {}};
      for (std::size_t k = 0; k < points.size(); ++k)
        if (const auto feature = seen(keyframe.camera_from_world * points[k], lens, random)) {
          keyframe.features.push_back(*feature);
          keyframe.features.back().track = static_cast<std::int64_t>(k);
          keyframe.features.back().depth_m *= 1 + own[k] + drift;
        }
      add_keyframe(map, camera, std::move(keyframe));
      drift = 0.8 * drift + drift_share * drifting.normal();
    }
    return map;
  }

  std::optional<Feature> seen(const Eigen::Vector3d& p, const Camera& lens, RandomStream& random) const {
    const auto pixel = lens.project(p);
    if (!pixel || !lens.contains(*pixel)) return std::nullopt;
    Feature feature;
    feature.pixel = *pixel + kPixelSigma * Eigen::Vector2d(random.normal(), random.normal());
    const double inverse_depth = 1 / p.z() + bias_per_m;
    feature.depth_sigma_m = depth_share * p.z() * p.z();  // as of stereo
    feature.depth_m = 1 / inverse_depth + feature.depth_sigma_m * random.normal();
    return feature;
  }
};

// Pulls of several draws: their mean tells a bias of the estimate, their square whether its sigma holds.
struct Pulls {
  double mean = 0, square = 0, mean_sigma = 0;
};

Pulls pulls(Orbit orbit, int draws) {
  Pulls sums;
  const Camera camera;
  for (int i = 0; i < draws; ++i) {
    orbit.seed = 100 + i;
    const auto found = calibrate_depth(orbit.map(camera), camera, kPixelSigma);
    EXPECT_TRUE(found);
    if (!found) return sums;
    const double pull = (found->per_m - orbit.bias_per_m) / found->sigma_per_m;
    sums.mean += pull / draws;
    sums.square += pull * pull / draws;
    sums.mean_sigma += found->sigma_per_m / draws;
  }
  return sums;
}

constexpr int kDraws = 12;

void expect_honest(const Pulls& pulls) {
  EXPECT_LT(std::abs(pulls.mean), 4 / std::sqrt(double(kDraws)));
  EXPECT_GT(pulls.square, 0.2);
  EXPECT_LT(pulls.square, 3.2);  // chi-square of 12 draws: above with a chance of 1e-4
}

TEST(DepthCalibration, FindsTheBiasWithinItsSigma) {
  const Pulls found = pulls({.bias_per_m = 0.006}, kDraws);
  expect_honest(found);
  EXPECT_LT(found.mean_sigma, 0.0015);
}

TEST(DepthCalibration, FindsABiasOfTheOtherSign) {
  expect_honest(pulls({.bias_per_m = -0.006}, kDraws));
}

// Noise alone must not pass for a bias, as it does where depths are corrected before they are compared.
TEST(DepthCalibration, FindsNoneInMuchNoise) {
  expect_honest(pulls({.depth_share = 0.02}, kDraws));
}

TEST(DepthCalibration, DoesNotBlameDepthForTheFocalLength) {
  expect_honest(pulls({.bias_per_m = 0.006, .focal_error = 0.004}, kDraws));
}

// As where a camera hardly moves, and sees the same error of a surface again and again.
TEST(DepthCalibration, ItsSigmaCoversErrorsThatStayWithAPoint) {
  expect_honest(pulls({.bias_per_m = 0.006, .own_share = 0.01}, kDraws));
}

// As of a sensor that warms up.
TEST(DepthCalibration, ItsSigmaCoversErrorsThatAllPointsShareForAWhile) {
  expect_honest(pulls({.bias_per_m = 0.006, .drift_share = 0.005}, kDraws));
}

TEST(DepthCalibration, NeedsKeyframes) {
  const Camera camera;
  EXPECT_FALSE(calibrate_depth(EgoMap{}, camera, kPixelSigma));
  EXPECT_FALSE(calibrate_depth(Orbit{.frames = 3}.map(camera), camera, kPixelSigma));
}

// Without motion nothing tells depth and bias apart: the prior is left.
TEST(DepthCalibration, KnowsThatACameraAtRestTellsNothing) {
  const Camera camera;
  EgoMap map = Orbit{.bias_per_m = 0.006, .frames = 1}.map(camera);
  EgoMap resting;
  for (int i = 0; i < 10; ++i)
    add_keyframe(resting, camera, {i, map.keyframes[0].camera_from_world, map.keyframes[0].features});
  const auto found = calibrate_depth(resting, camera, kPixelSigma);
  ASSERT_TRUE(found);
  EXPECT_LT(std::abs(found->per_m), 0.002);
  EXPECT_GT(found->sigma_per_m, 0.0045);
}

// As depth off by one sigma moves and scales what is seen, about a camera that stands anywhere.
TEST(DepthCalibration, ItsSigmaEntersTheStates) {
  const Camera camera;
  const Pose world_from_camera{
      Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, 3).normalized())), {0.5, -1, 2}};
  const Eigen::Vector2d pixel(400, 100);
  const double z = 1.7, sigma = 1e-5, size_px = 60;
  const auto place = [&](double z_m) {
    const Eigen::Vector3d ray = *camera.unproject(pixel);
    return Eigen::Vector3d(world_from_camera * Eigen::Vector3d(ray / ray.z() * z_m));
  };
  const double off_m = 1 / (1 / z + sigma);
  const Eigen::Vector3d moved = place(off_m) - place(z);
  const double grown_m = size_px / camera.fx * (off_m - z);
  ObjectState state;
  state.ellipsoid = {{Eigen::Quaterniond::Identity(), place(z)},
                     Eigen::Vector3d::Constant(size_px / camera.fx * z)};
  state.covariance_diagonal = Vector9d::Constant(1e-12);
  add_bias_variance({0.003, sigma}, world_from_camera, state);
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(state.covariance_diagonal[axis], 1e-12 + grown_m * grown_m, 1e-3 * grown_m * grown_m);
    EXPECT_NEAR(state.covariance_diagonal[3 + axis], 1e-12 + moved[axis] * moved[axis],
                1e-3 * moved.squaredNorm());
    EXPECT_EQ(state.covariance_diagonal[6 + axis], 1e-12);
  }
}

}  // namespace
}  // namespace uniquadric
