#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>

namespace ceres {
class CostFunction;
}

namespace uniquadric {

enum class AxisScale {
  metres,       ///< r = (a - a_prior) / sigma, as Eq. 15 is printed
  logarithmic,  ///< r = (ln a - ln a_prior) / (sigma / a_prior): the same to first order, linear in the block
};

/// Prior of the semi-axes (Eq. 15), each weighted by its own sigma. Block: ln a (3).
std::unique_ptr<ceres::CostFunction> axis_prior_factor(const Eigen::Vector3d& semi_axes_m,
                                                       const Eigen::Vector3d& sigma_m,
                                                       AxisScale scale = AxisScale::metres);

struct ExponentPriorOptions {
  double sigma = 2;         // ours: of q towards 2; over the whole range (1, 2) it costs 1/8, a sigma half
  double block_sigma = 20;  // ours: of s towards 0; where the sigmoid is flat s would not be determined
  // of the difference of the profiles above and below: the half that nobody sees is as the other one
  double profile_sigma = std::numeric_limits<double>::infinity();
};

/// Weak prior of each exponent towards the quadric, r = [ (q - 2) / sigma ; s / block_sigma ], and of three
/// r = (q_upper - q_lower) / profile_sigma besides.
/// Block: exponents (`exponents` = 1 or 3); residuals: two for each, and the one of both profiles last.
std::unique_ptr<ceres::CostFunction> exponent_prior_factor(int exponents,
                                                           const ExponentPriorOptions& options = {});

}  // namespace uniquadric
