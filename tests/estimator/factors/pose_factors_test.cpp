#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "estimator/factors/motion_model.h"
#include "estimator/factors/pose_block.h"
#include "estimator/factors/pose_prior.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

const Pose kPose{exp_so3({0.3, -1.1, 0.4}), {1.5, -0.2, 2.5}};
const PoseSigmas kSigmas{0.05, 0.02};

TEST(PoseManifold, PlusIsTheProductWithASmallPoseAndMinusUndoesIt) {
  const auto manifold = pose_manifold();
  const PoseBlock x = pose_block(kPose);
  for (const double scale : {1.0, 1e-9}) {
    const Vector6d delta = scale * (Vector6d() << 0.2, -0.1, 0.4, 0.5, -0.3, 0.8).finished();
    PoseBlock y;
    Vector6d back;
    manifold->Plus(x.data(), delta.data(), y.data());
    manifold->Minus(y.data(), x.data(), back.data());
    const Pose expected = kPose * Pose{exp_so3(delta.tail<3>()), delta.head<3>()};
    EXPECT_TRUE(pose_from_block(y).matrix().isApprox(expected.matrix(), 1e-14));
    EXPECT_LT((back - delta).norm(), 1e-15 + 1e-14 * scale);
  }
}

TEST(PoseManifold, JacobiansInvertEachOtherAndMatchDifferences) {
  const auto manifold = pose_manifold();
  for (const auto& rotation : test_rotations()) {
    const PoseBlock x = pose_block({rotation, kPose.translation});
    Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> minus;
    manifold->PlusJacobian(x.data(), plus.data());
    manifold->MinusJacobian(x.data(), minus.data());
    EXPECT_TRUE((minus * plus).isIdentity(1e-14));
    for (int i = 0; i < 6; ++i) {
      constexpr double kStep = 1e-5;
      const Vector6d delta = kStep * Vector6d::Unit(i);
      Eigen::Matrix<double, 7, 1> ahead, behind;
      manifold->Plus(x.data(), delta.data(), ahead.data());
      manifold->Plus(x.data(), Vector6d(-delta).data(), behind.data());
      EXPECT_LT(((ahead - behind) / (2 * kStep) - plus.col(i)).norm(), 1e-9);
    }
  }
}

TEST(PosePrior, Eq16_IsTheLogarithmWeightedApart) {
  const Vector6d xi = (Vector6d() << 0.1, -0.2, 0.3, 0.4, 0.5, -0.6).finished();
  const auto cost = pose_prior_factor(kPose, kSigmas);
  const Eigen::VectorXd r = residuals_of(*cost, blocks_of(pose_block(kPose * exp_se3(xi))));
  EXPECT_LT((r.head<3>() - xi.head<3>() / 0.05).norm(), 1e-12);
  EXPECT_LT((r.tail<3>() - xi.tail<3>() / 0.02).norm(), 1e-12);
  EXPECT_EQ(residuals_of(*cost, blocks_of(pose_block(kPose))).norm(), 0);
}

TEST(PosePrior, Eq16_JacobianMatchesDifferences) {
  Eigen::Matrix<double, 6, 6> S = Eigen::Matrix<double, 6, 6>::Identity();
  S(0, 4) = 0.7, S(2, 3) = -0.4, S(5, 5) = 3;
  for (const auto& rotation : test_rotations()) {
    const Pose error{rotation, {0.3, -0.4, 0.2}};
    const Blocks at = blocks_of(pose_block(kPose * error));
    expect_jacobians(*pose_prior_factor(kPose, kSigmas), at);
    expect_jacobians(*pose_prior_factor(kPose, S), at);
  }
}

TEST(RelativePose, JacobianMatchesDifferencesAndATrueMeasurementHasNoResidual) {
  for (const auto& rotation : test_rotations()) {
    const Pose b{rotation, {0.4, 0.1, -0.3}};
    const Pose measured{exp_so3({0.1, 0.2, -0.1}), {0.2, 0, 0.1}};
    expect_jacobians(*relative_pose_factor(measured, kSigmas),
                     blocks_of(pose_block(kPose), pose_block(kPose * b)));
    const auto exact = relative_pose_factor(b, kSigmas);
    EXPECT_LT(residuals_of(*exact, blocks_of(pose_block(kPose), pose_block(kPose * b))).norm(), 1e-11);
  }
}

TEST(LandmarkPrior, IsTheInformationAboutItsLinearisationPoint) {
  Eigen::Matrix3d S;
  S << 2, 1, 0, 0, 3, -1, 0, 0, 4;
  const Eigen::Vector3d p0(0.1, 0.2, 0.3), p(0.15, 0.1, 0.4);
  const auto cost = landmark_prior_factor(p0, S);
  expect_jacobians(*cost, blocks_of(p));
  const double cost_value = residuals_of(*cost, blocks_of(p)).squaredNorm();
  EXPECT_NEAR(cost_value, (p - p0).dot(S.transpose() * S * (p - p0)), 1e-14);
}

// What a model says is constant has no residual, over unequal steps.
TEST(MotionModel, Eq7_ConstantVelocityHasNoResidual) {
  const Eigen::Vector3d velocity(0.3, -0.1, 0.2), turn(0.5, 1.0, -0.4);
  const auto straight = [&](double t) {
    return Pose{kPose.rotation * exp_so3(t * turn), kPose.translation + t * velocity};
  };
  const Vector6d twist = (Vector6d() << velocity, turn).finished();
  const auto screw = [&](double t) { return kPose * exp_se3(t * twist); };
  for (const double ratio : {0.5, 1.0, 2.5}) {
    const auto a = motion_model_factor(ratio, MotionModel::straight, kSigmas);
    const auto b = motion_model_factor(ratio, MotionModel::screw, kSigmas);
    const auto at = [&](const auto& path) {
      return blocks_of(pose_block(path(0)), pose_block(path(0.4)), pose_block(path(0.4 + 0.4 * ratio)));
    };
    EXPECT_LT(residuals_of(*a, at(straight)).norm(), 1e-10);
    EXPECT_LT(residuals_of(*b, at(screw)).norm(), 1e-10);
    EXPECT_GT(residuals_of(*a, at(screw)).norm(), 0.1);
    EXPECT_GT(residuals_of(*b, at(straight)).norm(), 0.1);
  }
}

TEST(MotionModel, Eq7_ScrewDoesNotDependOnTheFrameInTheBody) {
  const Pose t0 = kPose, t1 = kPose * Pose{exp_so3({0.1, 0, 0.2}), {0.1, 0, 0}},
             offset{exp_so3({1, 2, 0}), {3, 0, 1}};
  const Pose a = predict_pose(t0, t1, 1.5, MotionModel::screw) * offset;
  const Pose b = predict_pose(t0 * offset, t1 * offset, 1.5, MotionModel::screw);
  EXPECT_TRUE(a.matrix().isApprox(b.matrix(), 1e-12));
}

TEST(MotionModel, Eq7_JacobianMatchesDifferences) {
  int tested = 0;
  for (const auto model : {MotionModel::straight, MotionModel::screw})
    for (const auto& error : test_rotations())
      for (const auto& step : {exp_so3({0.3, 0.2, -0.5}), exp_so3({1e-7, 0, 0}), exp_so3({0, 2.1, 0})}) {
        const Pose t1 = kPose * Pose{step, {0.2, -0.1, 0.3}};
        const Pose t2 = predict_pose(kPose, t1, 1.4, model) * Pose{error, {0.1, 0.2, -0.1}};
        expect_jacobians(*motion_model_factor(1.4, model, {0.5, 0.5}),
                         blocks_of(pose_block(kPose), pose_block(t1), pose_block(t2)), 1e-6);
        ++tested;
      }
  EXPECT_EQ(tested, 18);
}

// The sigma against a simulated random walk of the velocity.
TEST(MotionModel, PredictionSigmaIsThatOfWhiteAcceleration) {
  constexpr double kStep = 0.002;
  RandomStream random(3, "walk");
  double square = 0;
  constexpr int kTrials = 4000;
  for (int trial = 0; trial < kTrials; ++trial) {
    double x = 0, v = 0, x1 = 0;
    for (int i = 0; i < 150; ++i) {  // 0.1 s, then 0.2 s
      if (i == 50) x1 = x;
      const double dv = 2 * std::sqrt(kStep) * random.normal();
      x += (v + dv / 2) * kStep;
      v += dv;
    }
    square += std::pow(x - x1 - 2 * x1, 2) / kTrials;
  }
  const PoseSigmas sigmas = prediction_sigmas(0.1, 0.2, {2, 6});
  EXPECT_NEAR(std::sqrt(square), sigmas.translation_m,
              0.04 * sigmas.translation_m);  // 1 / sqrt(2 * 4000) = 1.1 %
  EXPECT_NEAR(sigmas.rotation_rad, 3 * sigmas.translation_m, 1e-15);
}

}  // namespace
}  // namespace uniquadric
