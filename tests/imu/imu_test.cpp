#include "simulator/imu/imu.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "simulator/scene/named_motions.h"
#include "simulator/scene/spline.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kRounding = 1e-12;  // a dozen operations on numbers up to 10
const Vector3d kX = Vector3d::UnitX(), kZ = Vector3d::UnitZ();

ImuRig noise_free() {
  ImuRig rig;
  rig.calibration.gyroscope_noise_radps_rthz = rig.calibration.gyroscope_walk_radps2_rthz = 0;
  rig.calibration.accelerometer_noise_mps2_rthz = rig.calibration.accelerometer_walk_mps3_rthz = 0;
  return rig;
}

std::vector<ImuSample> run(const Motion& motion, const ImuRig& rig, std::int64_t samples,
                           std::uint64_t seed = 1) {
  return simulate_imu(motion, rig, simulate_imu_biases(rig, samples, seed), 0, samples, seed);
}

Motion hand_held() {
  return spline_motion({{-1, {exp_so3({0.1, 0.2, 0.3}), {0, 0, 1}}},
                        {0.5, {exp_so3({0.9, -0.2, 0.6}), {1, 0.5, 1.2}}},
                        {1.3, {exp_so3({1.2, 0.6, -0.3}), {1.5, -0.4, 1.6}}},
                        {3, {exp_so3({-0.3, 1.2, 0.4}), {0.2, 0.1, 0.5}}},
                        {4, {exp_so3({-0.6, 0.9, 0.9}), {0, 0, 0}}},
                        {6, {exp_so3({0.2, 2.2, 0.8}), {-2, 1, 1}}}});
}

TEST(Imu, AtRestReadsGravityUpwards) {
  ImuRig rig = noise_free();
  rig.calibration.camera_from_imu = {exp_so3({0.4, -1.2, 2.0}), {0.1, 0.2, 0.3}};
  const Pose world_from_camera{exp_so3({1.0, 0.3, -0.7}), {5, 6, 7}};
  const Vector3d up = (world_from_camera * rig.calibration.camera_from_imu).rotation.conjugate() * kZ;
  const auto samples = run(static_motion(world_from_camera), rig, 3);
  ASSERT_EQ(samples.size(), 3u);
  for (const ImuSample& sample : samples) {
    EXPECT_EQ(sample.angular_velocity_radps, Vector3d::Zero());
    EXPECT_LT((sample.specific_force_mps2 - 9.81 * up).norm(), kRounding);
  }
}

TEST(Imu, InFreeFallReadsNothing) {
  // A pendulum without string: the outermost point of a circle of radius g / rate^2 in the vertical plane
  // falls freely at the top.
  const double rate = 3;
  CircleOptions circle;
  circle.normal = kX;
  circle.radius_m = 9.81 / (rate * rate);
  circle.rate_radps = rate;
  const Motion motion = circle_motion(circle);
  double top_s = 0;
  for (double t = 0; t < 2 * std::numbers::pi / rate; t += 1e-3)
    if (motion.at(t).translation.z() > motion.at(top_s).translation.z()) top_s = t;
  const ImuSample sample = true_imu_sample(motion, noise_free().calibration, std::llround(top_s * 1e9));
  EXPECT_LT(sample.specific_force_mps2.norm(), 9.81 * rate * 1e-3);  // the top is found within 1 ms
}

// An arm of length r that turns at w about the vertical, and speeds up at a: centripetal w^2 r inwards,
// tangential a r, gravity upwards.
TEST(Imu, OnALeverArmReadsCentripetalAndTangentialForce) {
  const double arm = 0.4, w0 = 1.5, sway = 0.3, period = 4;
  CircleOptions turntable;  // its centre is the camera's place: the camera itself stays
  turntable.radius_m = 1e-9;
  turntable.rate_radps = w0;
  turntable.sway_rad = sway;
  turntable.sway_period_s = period;
  turntable.facing = CircleOptions::Facing::tangent;
  ImuRig rig = noise_free();
  rig.calibration.camera_from_imu.translation = arm * kX;
  const double k = 2 * std::numbers::pi / period;
  constexpr double kTurntable = 1e-8;  // acceleration of the camera on its circle of 1 nm
  const auto samples = run(circle_motion(turntable), rig, 400);
  for (const ImuSample& sample : samples) {
    const double t = static_cast<double>(sample.stamp_ns) * 1e-9;
    const double w = w0 + sway * k * std::cos(k * t), a = -sway * k * k * std::sin(k * t);
    EXPECT_LT((sample.angular_velocity_radps - w * kZ).norm(), kRounding);
    EXPECT_LT((sample.specific_force_mps2 - Vector3d(-w * w * arm, a * arm, 9.81)).norm(), kTurntable);
  }
}

// Strapdown integration in steps of two samples: rotation by the fourth-order Magnus expansion (the mean rate
// by Simpson's rule and the commutator of the ends), velocity and position by Simpson's rule over the three
// rotated forces.
struct Strapdown {
  Pose pose;
  Vector3d velocity_mps;

  void advance(const ImuSample& a, const ImuSample& b, const ImuSample& c, const Vector3d& gravity_mps2) {
    const double h = static_cast<double>(c.stamp_ns - a.stamp_ns) * 1e-9;
    const auto &wa = a.angular_velocity_radps, &wb = b.angular_velocity_radps, &wc = c.angular_velocity_radps;
    // Whole and half step of the quadratic through the three rates.
    const Vector3d whole = h / 6 * (wa + 4 * wb + wc) + h * h / 12 * wa.cross(wc);
    const Vector3d half = h / 24 * (5 * wa + 8 * wb - wc) + h * h / 48 * wa.cross(wb);
    const Vector3d fa = pose.rotation * a.specific_force_mps2 + gravity_mps2;
    const Vector3d fb = pose.rotation * exp_so3(half) * b.specific_force_mps2 + gravity_mps2;
    pose.rotation = (pose.rotation * exp_so3(whole)).normalized();
    const Vector3d fc = pose.rotation * c.specific_force_mps2 + gravity_mps2;
    pose.translation += h * velocity_mps + h * h / 6 * (fa + 2 * fb);
    velocity_mps += h / 6 * (fa + 4 * fb + fc);
  }
};

double drift_m(double rate_hz, double* turn_rad) {
  ImuRig rig = noise_free();
  rig.calibration.rate_hz = rate_hz;
  rig.calibration.camera_from_imu = {exp_so3({0.5, -0.5, 1}), {0.05, -0.1, 0.2}};
  const Motion motion = hand_held();
  const auto samples = run(motion, rig, static_cast<std::int64_t>(5 * rate_hz) + 1);
  const Kinematics camera = motion.kinematics(0);
  const Pose imu_start = camera.pose * rig.calibration.camera_from_imu;
  const Vector3d arm = rig.calibration.camera_from_imu.translation;
  Strapdown state{imu_start,
                  camera.velocity_mps + camera.pose.rotation * camera.angular_velocity_radps.cross(arm)};
  for (std::size_t k = 0; k + 2 < samples.size(); k += 2)
    state.advance(samples[k], samples[k + 1], samples[k + 2], {0, 0, -9.81});
  const Pose end = motion.at(5) * rig.calibration.camera_from_imu;
  *turn_rad = log_so3(end.rotation.conjugate() * state.pose.rotation).norm();
  return (end.translation - state.pose.translation).norm();
}

TEST(Imu, StrapdownIntegrationReturnsTheTrajectory) {
  // Truncation of fourth order: h^4 of 10 ms steps times derivatives of order 1 to 100 over 5 s, with the
  // spline's knots at the ends of steps. Four times the rate leaves a 256th.
  constexpr double kPosition_m = 1e-7, kTurn_rad = 1e-8, kGain = 100;
  double turn_rad, fine_turn_rad;
  const double drift = drift_m(200, &turn_rad), fine = drift_m(800, &fine_turn_rad);
  EXPECT_LT(drift, kPosition_m);
  EXPECT_LT(turn_rad, kTurn_rad);
  EXPECT_LT(fine, drift / kGain);
  EXPECT_LT(fine_turn_rad, turn_rad / kGain);
  printf("after 5 s: %.2g m, %.2g rad at 200 Hz; %.2g m, %.2g rad at 800 Hz\n", drift, turn_rad, fine,
         fine_turn_rad);
}

struct Moments {
  double mean = 0, variance = 0;
  std::int64_t count = 0;
};

Moments moments(const std::vector<double>& values) {
  Moments m;
  m.count = std::ssize(values);
  for (const double v : values) m.mean += v / static_cast<double>(m.count);
  for (const double v : values) m.variance += (v - m.mean) * (v - m.mean) / static_cast<double>(m.count);
  return m;
}

// Variances of n normal numbers spread by sqrt(2 / n) of themselves: 5 sigma, and a fixed seed.
double spread(double n) {
  return 5 * std::sqrt(2 / n);
}

TEST(Imu, WhiteNoiseHasTheDensityAskedFor) {
  ImuRig rig = noise_free();
  rig.calibration.rate_hz = 400;
  rig.calibration.gyroscope_noise_radps_rthz = 2e-4;
  rig.calibration.accelerometer_noise_mps2_rthz = 3e-3;
  const auto samples = run(static_motion({}), rig, 20'000);
  int axes = 0;
  for (int k = 0; k < 3; ++k, ++axes) {
    std::vector<double> rates, forces, products;
    for (const ImuSample& s : samples) {
      rates.push_back(s.angular_velocity_radps[k]);
      forces.push_back(s.specific_force_mps2[k] - (k == 2 ? 9.81 : 0));
    }
    for (std::size_t i = 1; i < rates.size(); ++i) products.push_back(rates[i] * rates[i - 1]);
    const Moments rate = moments(rates), force = moments(forces);
    EXPECT_NEAR(rate.variance / (4e-8 * 400), 1, spread(20'000));
    EXPECT_NEAR(force.variance / (9e-6 * 400), 1, spread(20'000));
    const double of_mean = 5 / std::sqrt(20'000.0);
    EXPECT_NEAR(rate.mean / std::sqrt(rate.variance), 0, of_mean);
    EXPECT_NEAR(moments(products).mean / rate.variance, 0, of_mean) << "white: neighbours are independent";
  }
  EXPECT_EQ(axes, 3);
}

// Brownian motion: the increments over m steps have variance walk^2 m dt for every m, which is what the
// +1/2 slope of an Allan plot says.
TEST(Imu, BiasWalksAsItsDensitySays) {
  ImuRig rig;
  rig.calibration.rate_hz = 100;
  rig.gyroscope_bias_radps = {0.01, -0.02, 0.03};
  rig.accelerometer_bias_mps2 = {0.1, 0.2, -0.3};
  const std::int64_t samples = 40'000;
  const auto biases = simulate_imu_biases(rig, samples, 3);
  EXPECT_EQ(biases[0].gyroscope_radps, rig.gyroscope_bias_radps);
  EXPECT_EQ(biases[0].accelerometer_mps2, rig.accelerometer_bias_mps2);
  int checked = 0;
  for (const std::int64_t m : {1, 10, 100}) {
    std::vector<double> gyroscope, accelerometer;
    for (std::int64_t k = 0; k + m < samples; k += m)
      for (int axis = 0; axis < 3; ++axis) {
        const ImuBias &a = biases[static_cast<std::size_t>(k)], &b = biases[static_cast<std::size_t>(k + m)];
        gyroscope.push_back(b.gyroscope_radps[axis] - a.gyroscope_radps[axis]);
        accelerometer.push_back(b.accelerometer_mps2[axis] - a.accelerometer_mps2[axis]);
      }
    const double dt = static_cast<double>(m) / 100, n = static_cast<double>(gyroscope.size());
    const double g = rig.calibration.gyroscope_walk_radps2_rthz,
                 a = rig.calibration.accelerometer_walk_mps3_rthz;
    EXPECT_NEAR(moments(gyroscope).variance / (g * g * dt), 1, spread(n));
    EXPECT_NEAR(moments(accelerometer).variance / (a * a * dt), 1, spread(n));
    ++checked;
  }
  EXPECT_EQ(checked, 3);
}

// Allan variance of a whole signal: white noise N^2 / tau at short, the walk's K^2 tau / 3 at long times.
TEST(Imu, AllanDeviationFollowsBothDensities) {
  ImuRig rig = noise_free();
  rig.calibration.rate_hz = 50;
  const double N = rig.calibration.gyroscope_noise_radps_rthz = 1e-3;
  const double K = rig.calibration.gyroscope_walk_radps2_rthz = 1e-3;
  const std::int64_t samples = 100'000;
  const auto signal = run(static_motion({}), rig, samples, 5);
  int checked = 0;
  for (const int m : {1, 10, 50, 200}) {
    double sum = 0, n = 0;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> means;
      for (std::int64_t k = 0; k + m <= samples; k += m) {
        double mean = 0;
        for (int i = 0; i < m; ++i)
          mean += signal[static_cast<std::size_t>(k + i)].angular_velocity_radps[axis] / m;
        means.push_back(mean);
      }
      for (std::size_t i = 1; i < means.size(); ++i, ++n) sum += std::pow(means[i] - means[i - 1], 2) / 2;
    }
    const double tau = m / 50.0;
    // The mean of m values of a walk in steps: the continuous walk's 1/3 gains 1 / (6 m^2).
    const double expected = N * N / tau + K * K * tau * (1.0 / 3 + 1.0 / (6.0 * m * m));
    // Neighbouring differences share a mean: their variance is 1.5 to 2 times that of independent ones.
    EXPECT_NEAR(sum / n / expected, 1, 1.5 * spread(n)) << "tau " << tau;
    ++checked;
  }
  EXPECT_EQ(checked, 4);
}

TEST(Imu, SlicesJoinToTheWholeAndSeedsDiffer) {
  const ImuRig rig;
  const Motion motion = hand_held();
  const std::int64_t samples = 301;
  const auto whole = run(motion, rig, samples, 9);
  const auto biases = simulate_imu_biases(rig, samples, 9);
  for (const std::int64_t cut : {1, 150, 299}) {
    auto joined = simulate_imu(motion, rig, simulate_imu_biases(rig, cut, 9), 0, cut, 9);
    for (const ImuSample& s : simulate_imu(motion, rig, biases, cut, samples, 9)) joined.push_back(s);
    ASSERT_EQ(joined.size(), whole.size());
    for (std::size_t k = 0; k < whole.size(); ++k) {
      EXPECT_EQ(joined[k].angular_velocity_radps, whole[k].angular_velocity_radps);
      EXPECT_EQ(joined[k].specific_force_mps2, whole[k].specific_force_mps2);
    }
  }
  EXPECT_NE(run(motion, rig, 1, 10)[0].specific_force_mps2, whole[0].specific_force_mps2);
}

TEST(Imu, SaturatesAtItsRange) {
  ImuRig rig = noise_free();
  rig.gyroscope_range_radps = 1;
  rig.accelerometer_range_mps2 = 9;
  ScrewOptions spin;
  spin.rate_radps = -2;
  const auto samples = run(screw_motion(spin), rig, 2);
  for (const ImuSample& s : samples) {
    EXPECT_EQ(s.angular_velocity_radps, Vector3d(0, 0, -1));
    EXPECT_LT((s.specific_force_mps2 - Vector3d(0, 0, 9)).norm(), kRounding);
  }
}

TEST(Imu, SamplesSurroundTheSequence) {
  ImuCalibration imu;
  int cases = 0;
  for (const double rate : {1.0, 30.0, 199.9, 200.0, 1000.0})
    for (const std::int64_t end_ns : {0LL, 1LL, 33'333'333LL, 5'000'000LL, 9'966'666'667LL}) {
      imu.rate_hz = rate;
      const std::int64_t count = imu_sample_count(imu, end_ns);
      EXPECT_GE(imu_stamp_ns(imu, count - 1), end_ns);
      if (count > 1) {
        EXPECT_LT(imu_stamp_ns(imu, count - 2), end_ns);
      }
      ++cases;
    }
  EXPECT_EQ(cases, 25);
}

}  // namespace
}  // namespace uniquadric
