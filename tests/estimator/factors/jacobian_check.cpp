#include "tests/estimator/factors/jacobian_check.h"

#include <ceres/cost_function.h>
#include <ceres/manifold.h>
#include <gtest/gtest.h>

#include <numbers>

#include "estimator/factors/pose_block.h"

namespace uniquadric {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

constexpr double kStep = 1e-4;  // of the larger difference; the extrapolated error falls as its fourth power

std::vector<const double*> pointers(const Blocks& blocks) {
  std::vector<const double*> p;
  for (const auto& block : blocks) p.push_back(block.data());
  return p;
}

int tangent_size(const std::vector<double>& block) {
  return block.size() == 7 ? 6 : static_cast<int>(block.size());
}

std::vector<double> moved(const std::vector<double>& block, int direction, double step) {
  std::vector<double> result = block;
  if (block.size() == 7) {
    Vector6d delta = Vector6d::Zero();
    delta[direction] = step;
    pose_manifold()->Plus(block.data(), delta.data(), result.data());
  } else {
    result[direction] += step;
  }
  return result;
}

Eigen::VectorXd difference(const ceres::CostFunction& cost, Blocks blocks, int block, int direction,
                           double step) {
  const std::vector<double> here = blocks[block];
  blocks[block] = moved(here, direction, step);
  const Eigen::VectorXd ahead = residuals_of(cost, blocks);
  blocks[block] = moved(here, direction, -step);
  return (ahead - residuals_of(cost, blocks)) / (2 * step);
}

Eigen::MatrixXd numeric(const ceres::CostFunction& cost, const Blocks& blocks, int block) {
  Eigen::MatrixXd J(cost.num_residuals(), tangent_size(blocks[block]));
  for (int i = 0; i < J.cols(); ++i)
    J.col(i) =
        (4 * difference(cost, blocks, block, i, kStep / 2) - difference(cost, blocks, block, i, kStep)) / 3;
  return J;
}

std::vector<Eigen::MatrixXd> analytic(const ceres::CostFunction& cost, const Blocks& blocks) {
  std::vector<RowMajor> ambient;
  std::vector<double*> out;
  for (const auto& block : blocks)
    ambient.push_back(RowMajor::Constant(cost.num_residuals(), static_cast<int>(block.size()), NAN));
  for (auto& J : ambient) out.push_back(J.data());
  Eigen::VectorXd residuals(cost.num_residuals());
  EXPECT_TRUE(cost.Evaluate(pointers(blocks).data(), residuals.data(), out.data()));
  EXPECT_TRUE(residuals.isApprox(residuals_of(cost, blocks), 1e-14) || residuals.norm() < 1e-12)
      << "residuals differ when Jacobians are asked for";
  std::vector<Eigen::MatrixXd> local;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (blocks[i].size() == 7) {
      Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
      pose_manifold()->PlusJacobian(blocks[i].data(), plus.data());
      local.push_back(ambient[i] * plus);
    } else {
      local.push_back(ambient[i]);
    }
  }
  return local;
}

}  // namespace

Eigen::VectorXd residuals_of(const ceres::CostFunction& cost, const Blocks& blocks) {
  Eigen::VectorXd residuals = Eigen::VectorXd::Constant(cost.num_residuals(), NAN);
  EXPECT_TRUE(cost.Evaluate(pointers(blocks).data(), residuals.data(), nullptr));
  return residuals;
}

void expect_jacobians(const ceres::CostFunction& cost, const Blocks& blocks, double tolerance) {
  ASSERT_EQ(cost.parameter_block_sizes().size(), blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i)
    ASSERT_EQ(cost.parameter_block_sizes()[i], static_cast<int>(blocks[i].size()));
  const auto J = analytic(cost, blocks);
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Eigen::MatrixXd N = numeric(cost, blocks, static_cast<int>(i));
    EXPECT_TRUE(J[i].allFinite());
    EXPECT_LT((J[i] - N).cwiseAbs().maxCoeff(), tolerance * (1 + N.cwiseAbs().maxCoeff()))
        << "block " << i << "\nanalytic\n"
        << J[i] << "\nnumeric\n"
        << N;
  }
}

std::array<Eigen::Quaterniond, 3> test_rotations() {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, -2, 0.7).normalized();
  return {exp_so3(0.9 * axis), exp_so3(1e-7 * axis), exp_so3((std::numbers::pi - 1e-2) * axis)};
}

}  // namespace uniquadric
