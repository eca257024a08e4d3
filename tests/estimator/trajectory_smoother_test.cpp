#include "estimator/window/trajectory_smoother.h"

#include <gtest/gtest.h>

#include <functional>

#include "core/base/random.h"

namespace uniquadric {
namespace {

using Motion = std::function<Pose(double)>;
constexpr double kRate = 30;

Pose swing(double t) {
  const double angle = 0.9 * std::sin(2.1 * t);
  return {exp_so3({0, angle, 0.3 * t}), {1.2 * std::sin(angle), 0.1 * t, 1.2 * (1 - std::cos(angle))}};
}

Eigen::Vector3d noise(const char* stream, int frame, double sigma) {
  RandomStream random(7, stream, frame, 0);
  return {sigma * random.normal(), sigma * random.normal(), sigma * random.normal()};
}

// Poses at 30 Hz with white noise of sigmas that the covariances know.
std::vector<PoseSample> samples_of(const Motion& motion, int frames, double sigma_m, double sigma_rad) {
  std::vector<PoseSample> samples(static_cast<std::size_t>(frames));
  for (int i = 0; i < frames; ++i) {
    PoseSample& sample = samples[static_cast<std::size_t>(i)];
    sample.stamp_ns = std::llround(1e9 * i / kRate);
    sample.world_from_object = motion(i / kRate);
    sample.world_from_object.translation += noise("translation", i, sigma_m);
    sample.world_from_object.rotation =
        exp_so3(noise("rotation", i, sigma_rad)) * sample.world_from_object.rotation;
    sample.covariance.setZero();
    sample.covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    sample.covariance.diagonal().tail<3>().setConstant(sigma_rad * sigma_rad);
  }
  return samples;
}

struct Error {
  double largest_m = 0, largest_rad = 0;    // of a pose
  double step_rms_m = 0, step_rms_rad = 0;  // of how it went on since the frame before
};

Error error_of(const std::vector<PoseSample>& samples, const Motion& motion, std::size_t from = 0,
               std::size_t to = SIZE_MAX) {
  Error error;
  to = std::min(to, samples.size());
  for (std::size_t i = from; i < to; ++i) {
    const auto off = [&](std::size_t k) {
      const Pose truth = motion(1e-9 * static_cast<double>(samples[k].stamp_ns));
      const Pose& pose = samples[k].world_from_object;
      return std::pair<Eigen::Vector3d, Eigen::Vector3d>(pose.translation - truth.translation,
                                                         log_so3(pose.rotation * truth.rotation.inverse()));
    };
    const auto [t, r] = off(i);
    error.largest_m = std::max(error.largest_m, t.norm());
    error.largest_rad = std::max(error.largest_rad, r.norm());
    if (i == from) continue;
    const auto [t0, r0] = off(i - 1);
    error.step_rms_m += (t - t0).squaredNorm();
    error.step_rms_rad += (r - r0).squaredNorm();
  }
  error.step_rms_m = std::sqrt(error.step_rms_m / static_cast<double>(to - from - 1));
  error.step_rms_rad = std::sqrt(error.step_rms_rad / static_cast<double>(to - from - 1));
  return error;
}

void hide(std::vector<PoseSample>& samples, std::size_t from, std::size_t to) {
  for (std::size_t i = from; i < to; ++i) {
    samples[i].world_from_object = samples[from - 1].world_from_object;
    samples[i].evidence = PoseEvidence::none;
  }
}

TEST(TrajectorySmoother, ConstantAccelerationStaysAsItIsOverGapsAndUnevenStamps) {
  const Motion motion = [](double t) {
    return Pose{exp_so3({0, 0, 0.4 * t + 0.2 * t * t}), {0.3 * t, -0.2 * t * t, 1}};
  };
  std::vector<PoseSample> samples = samples_of(motion, 90, 0, 0);
  samples.erase(samples.begin() + 20, samples.begin() + 27);
  hide(samples, 40, 60);
  smooth_trajectory(samples, {});
  const Error error = error_of(samples, motion);
  EXPECT_LT(error.largest_m, 1e-6);
  EXPECT_LT(error.largest_rad, 1e-6);
}

TEST(TrajectorySmoother, TakesTheNoiseOfFramesOff) {
  std::vector<PoseSample> samples = samples_of(swing, 240, 0.003, 0.01);
  const Error before = error_of(samples, swing);
  smooth_trajectory(samples, {});
  const Error after = error_of(samples, swing);
  EXPECT_LT(after.step_rms_m, 0.2 * before.step_rms_m);
  EXPECT_LT(after.step_rms_rad, 0.2 * before.step_rms_rad);
  EXPECT_LT(after.largest_m, before.largest_m);
  EXPECT_LT(after.largest_rad, before.largest_rad);
}

TEST(TrajectorySmoother, CovariancesThatAreTooSmallByAFactorChangeNothing) {
  std::vector<PoseSample> told = samples_of(swing, 120, 0.003, 0.02), boasting = told;
  for (PoseSample& sample : boasting) sample.covariance /= 4;
  const TrajectorySmootherOptions exact{0, 0};
  smooth_trajectory(told, exact);
  smooth_trajectory(boasting, exact);
  for (std::size_t i = 0; i < told.size(); ++i) {
    EXPECT_LT((told[i].world_from_object.translation - boasting[i].world_from_object.translation).norm(),
              1e-6);
    EXPECT_TRUE(told[i].covariance.isApprox(boasting[i].covariance, 1e-3));
  }
}

// A body at rest is a parabola fitted to n poses; in the middle of the time its variance is 9 / (4 n) of one.
TEST(TrajectorySmoother, CovarianceOfABodyAtRestIsThatOfAFittedParabola) {
  const int n = 101;
  std::vector<PoseSample> samples = samples_of([](double) { return Pose(); }, n, 0.01, 0.02);
  TrajectorySmootherOptions options;
  options.outlier = 1e6;
  smooth_trajectory(samples, options);
  const PoseSample& middle = samples[n / 2];
  EXPECT_NEAR(middle.covariance(0, 0), 9.0 / (4 * n) * 1e-4, 0.3 * 9.0 / (4 * n) * 1e-4);
  EXPECT_NEAR(middle.covariance(4, 4), 9.0 / (4 * n) * 4e-4, 0.3 * 9.0 / (4 * n) * 4e-4);
  EXPECT_LT(middle.world_from_object.translation.norm(), 4 * std::sqrt(middle.covariance.trace()));
}

TEST(TrajectorySmoother, ABodyThatNeverMovesAtAllStaysAsItIs) {
  std::vector<PoseSample> samples;
  for (int k = 0; k < 20; ++k) {
    samples.push_back({k * 33'333'333LL, {Eigen::Quaterniond::Identity(), {1, 2, 3}}});
    samples.back().covariance.setZero();
  }
  smooth_trajectory(samples, {});
  for (const PoseSample& sample : samples) {
    EXPECT_EQ(sample.world_from_object.translation, Eigen::Vector3d(1, 2, 3));
    EXPECT_EQ(sample.world_from_object.rotation.coeffs(), Eigen::Quaterniond::Identity().coeffs());
    EXPECT_TRUE(sample.covariance.allFinite());
  }
}

TEST(TrajectorySmoother, FillsInASecondOfASwingThatNobodySaw) {
  std::vector<PoseSample> samples = samples_of(swing, 240, 0.001, 0.004);
  hide(samples, 100, 135);
  smooth_trajectory(samples, {});
  const Error hidden = error_of(samples, swing, 100, 135);
  EXPECT_LT(hidden.largest_m, 0.1);
  EXPECT_LT(hidden.largest_rad, 0.05);
  EXPECT_GT(samples[117].covariance(0, 0), 10 * samples[80].covariance(0, 0));
}

TEST(TrajectorySmoother, SpreadsADriftOverTheFramesThatDrifted) {
  std::vector<PoseSample> samples = samples_of(swing, 240, 0.001, 0.004);
  for (std::size_t i = 90; i < 120; ++i) {
    const double share = static_cast<double>(i - 89) / 30;
    samples[i].world_from_object.translation += share * Eigen::Vector3d(0.08, 0, 0);
    samples[i].world_from_object.rotation =
        exp_so3({0.3 * share, 0, 0}) * samples[i].world_from_object.rotation;
    samples[i].evidence = PoseEvidence::relative;
  }
  smooth_trajectory(samples, {});
  const Error error = error_of(samples, swing);
  EXPECT_LT(error.largest_m, 0.02);
  EXPECT_LT(error.largest_rad, 0.07);
  EXPECT_LT(error.step_rms_rad, 0.004);
}

// A body of revolution: poses tell the turn about its axis now and then, and wander by radians.
TEST(TrajectorySmoother, AnUnknownTurnDoesNotTiltTheAxis) {
  const Motion motion = [](double t) {
    return Pose{exp_so3({0, 0, 1.7 * t}) * exp_so3({1.2 + 0.35 * t, 0, 0}), {0.1 * t, 0, 0}};
  };
  auto samples = samples_of(motion, 120, 0.002, 0.01);
  double wander_rad = 0;
  for (std::size_t i = 0; i < samples.size(); ++i) {
    wander_rad += noise("wander", static_cast<int>(i), 1).x();
    samples[i].world_from_object.rotation *= exp_so3({0, 0, wander_rad});
    samples[i].covariance(5, 5) = i % 20 < 3 ? 1e-3 : 0.3;
  }
  smooth_trajectory(samples, {});
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
    const Eigen::Quaterniond truth = motion(static_cast<double>(i) / kRate).rotation;
    EXPECT_LT((samples[i].world_from_object.rotation * z).cross(truth * z).norm(), 0.02) << i;
  }
}

// A body that goes by a new face slips once, by 3 cm, and is found where it is when the face of before is
// back.
TEST(TrajectorySmoother, ASlippedStepIsNotSpreadOverTheOthers) {
  auto samples = samples_of(swing, 150, 0.001, 0.002);
  for (std::size_t i = 60; i < 90; ++i) {
    samples[i].evidence = PoseEvidence::relative;
    if (i >= 65) samples[i].world_from_object.translation.x() += 0.03;
  }
  smooth_trajectory(samples, {});
  EXPECT_LT(error_of(samples, swing).largest_m, 0.006);
}

// A body that goes by a new face is struck. Nobody finds the face of before again.
TEST(TrajectorySmoother, ABlowIsNoSlip) {
  const Motion struck = [](double t) {
    return Pose{Eigen::Quaterniond::Identity(), {t < 2 ? 0 : 0.05 + 0.1 * (t - 2), 0, 0}};
  };
  auto samples = samples_of(struck, 150, 0.001, 0.002);
  for (std::size_t i = 50; i < samples.size(); ++i) samples[i].evidence = PoseEvidence::relative;
  smooth_trajectory(samples, {});
  EXPECT_LT(error_of(samples, struck, 65).largest_m, 0.01);
}

TEST(TrajectorySmoother, AWrongPoseAndAWrongGuessHardlyCount) {
  std::vector<PoseSample> samples = samples_of(swing, 240, 0.001, 0.004);
  samples[50].world_from_object.translation.z() += 0.3;
  for (std::size_t i = 150; i < 156; ++i) {
    samples[i].world_from_object.translation.x() += 0.2;
    samples[i].evidence = PoseEvidence::guess;
  }
  smooth_trajectory(samples, {});
  EXPECT_LT(error_of(samples, swing).largest_m, 0.01);
}

TEST(TrajectorySmoother, FramesCloseInTimeAndLongGapsDoNoHarm) {
  for (const std::int64_t apart_ns : {1, 1000, 100'000, 200'000, 1'000'000, 5'000'000}) {
    std::vector<PoseSample> samples = samples_of(swing, 120, 0.001, 0.004);
    samples[61] = samples[60];
    samples[61].stamp_ns += apart_ns;
    for (std::size_t i = 110; i < samples.size(); ++i) samples[i].stamp_ns += 3'000'000'000;
    smooth_trajectory(samples, {});
    EXPECT_LT(error_of(samples, swing, 0, 105).largest_m, 0.02) << apart_ns;
    EXPECT_LT(error_of(samples, swing, 0, 105).largest_rad, 0.02) << apart_ns;
  }
}

TEST(TrajectorySmoother, WhatComesAfterTheLastEvidenceStaysPredicted) {
  std::vector<PoseSample> samples = samples_of(swing, 60, 0.001, 0.004);
  hide(samples, 50, 60);
  const Pose predicted = samples[55].world_from_object;
  smooth_trajectory(samples, {});
  EXPECT_EQ(samples[55].world_from_object.translation, predicted.translation);
  std::vector<PoseSample> nothing = samples_of(swing, 20, 0, 0);
  hide(nothing, 1, 20);
  const std::vector<PoseSample> before = nothing;
  smooth_trajectory(nothing, {});
  for (std::size_t i = 0; i < nothing.size(); ++i)
    EXPECT_EQ(nothing[i].world_from_object.translation, before[i].world_from_object.translation);
}

}  // namespace
}  // namespace uniquadric
