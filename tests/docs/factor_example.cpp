// The example of docs/add_factor.md, which quotes it.
#include <ceres/autodiff_cost_function.h>
#include <ceres/problem.h>
#include <ceres/solver.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/factors/shape_block.h"
#include "estimator/factors/shape_prior.h"
#include "tests/estimator/factors/jacobian_check.h"

namespace uniquadric {
namespace {

class EqualAxes {
 public:
  EqualAxes(int i, int j, double sigma) : i_(i), j_(j), sigma_(sigma) {}

  template <typename T>
  bool operator()(const T* log_axes, T* residual) const {
    residual[0] = (log_axes[i_] - log_axes[j_]) / T(sigma_);
    return true;
  }

 private:
  int i_, j_;
  double sigma_;
};

/// A body of revolution: semi-axes i and j are equal, r = (ln a_i - ln a_j) / sigma, sigma being relative.
/// Block: ln a (3).
std::unique_ptr<ceres::CostFunction> equal_axes_factor(int i, int j, double sigma) {
  return std::make_unique<ceres::AutoDiffCostFunction<EqualAxes, 1, 3>>(new EqualAxes(i, j, sigma));
}

TEST(EqualAxes, IsTheRelativeDifferenceOverItsSigma) {
  const AxesBlock axes = axes_block({0.4, 0.2, 0.2});
  EXPECT_NEAR(residuals_of(*equal_axes_factor(0, 1, 0.1), blocks_of(axes))[0], std::log(2) / 0.1, 1e-12);
  EXPECT_EQ(residuals_of(*equal_axes_factor(1, 2, 0.1), blocks_of(axes))[0], 0);
}

TEST(EqualAxes, JacobianMatchesDifferences) {
  expect_jacobians(*equal_axes_factor(2, 0, 0.1), blocks_of(axes_block({0.4, 0.2, 0.3})));
}

// Beside priors of one relative sigma, two axes meet at their geometric mean and the third stays.
TEST(EqualAxes, TwoAxesMeetAtTheirGeometricMean) {
  const Eigen::Vector3d prior(0.4, 0.1, 0.3);
  AxesBlock axes = axes_block(prior);
  ceres::Problem problem;
  problem.AddResidualBlock(axis_prior_factor(prior, 0.1 * prior, AxisScale::logarithmic).release(), nullptr,
                           axes.data());
  problem.AddResidualBlock(equal_axes_factor(0, 1, 1e-6).release(), nullptr, axes.data());
  ceres::Solver::Options options;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  EXPECT_LT((axes_from_block(axes.data()) - Eigen::Vector3d(0.2, 0.2, 0.3)).norm(), 1e-6);
}

}  // namespace
}  // namespace uniquadric
