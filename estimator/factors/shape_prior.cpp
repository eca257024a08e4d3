#include "estimator/factors/shape_prior.h"

#include <ceres/sized_cost_function.h>

#include <cassert>

#include "estimator/factors/shape_block.h"

namespace uniquadric {
namespace {

class AxisPrior final : public ceres::SizedCostFunction<3, 3> {
 public:
  AxisPrior(const Eigen::Vector3d& semi_axes_m, const Eigen::Vector3d& sigma_m, AxisScale scale)
      : axes_(semi_axes_m), sigma_(sigma_m), scale_(scale) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    const Eigen::Vector3d axes = axes_from_block(blocks[0]);
    Eigen::Map<Eigen::Vector3d> r(residuals);
    Eigen::Vector3d slope;
    if (scale_ == AxisScale::metres) {
      r = (axes - axes_).cwiseQuotient(sigma_);
      slope = axes.cwiseQuotient(sigma_);
    } else {
      slope = axes_.cwiseQuotient(sigma_);
      r = axes.cwiseQuotient(axes_).array().log().matrix().cwiseProduct(slope);
    }
    if (jacobians && jacobians[0])
      Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>{jacobians[0]} =
          Eigen::Matrix3d(slope.asDiagonal());
    return true;
  }

 private:
  Eigen::Vector3d axes_, sigma_;
  AxisScale scale_;
};

constexpr int residuals_of(int exponents) {
  return 2 * exponents + (exponents == 3 ? 1 : 0);
}

template <int Exponents>
class ExponentPrior final : public ceres::SizedCostFunction<residuals_of(Exponents), Exponents> {
 public:
  explicit ExponentPrior(const ExponentPriorOptions& options) : options_(options) {}

  bool Evaluate(double const* const* blocks, double* residuals, double** jacobians) const override {
    constexpr int kResiduals = residuals_of(Exponents);
    Eigen::Matrix<double, kResiduals, Exponents> slopes = decltype(slopes)::Zero();
    for (int i = 0; i < Exponents; ++i) {
      const double s = blocks[0][i];
      residuals[2 * i] = (exponent_from_block(s) - 2) / options_.sigma;
      residuals[2 * i + 1] = s / options_.block_sigma;
      slopes(2 * i, i) = exponent_slope(s) / options_.sigma;
      slopes(2 * i + 1, i) = 1 / options_.block_sigma;
    }
    if constexpr (Exponents == 3) {
      const double upper = blocks[0][1], lower = blocks[0][2];
      residuals[6] = (exponent_from_block(upper) - exponent_from_block(lower)) / options_.profile_sigma;
      slopes(6, 1) = exponent_slope(upper) / options_.profile_sigma;
      slopes(6, 2) = -exponent_slope(lower) / options_.profile_sigma;
    }
    if (jacobians && jacobians[0])
      for (int row = 0; row < kResiduals; ++row)
        for (int i = 0; i < Exponents; ++i) jacobians[0][row * Exponents + i] = slopes(row, i);
    return true;
  }

 private:
  ExponentPriorOptions options_;
};

}  // namespace

std::unique_ptr<ceres::CostFunction> axis_prior_factor(const Eigen::Vector3d& semi_axes_m,
                                                       const Eigen::Vector3d& sigma_m, AxisScale scale) {
  return std::make_unique<AxisPrior>(semi_axes_m, sigma_m, scale);
}

std::unique_ptr<ceres::CostFunction> exponent_prior_factor(int exponents,
                                                           const ExponentPriorOptions& options) {
  assert(exponents == 1 || exponents == 3);
  if (exponents == 3) return std::make_unique<ExponentPrior<3>>(options);
  return std::make_unique<ExponentPrior<1>>(options);
}

}  // namespace uniquadric
