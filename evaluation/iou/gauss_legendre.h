#pragma once

#include <vector>

namespace uniquadric {

struct QuadratureRule {
  std::vector<double> nodes, weights;  ///< on [-1, 1]
};

/// Gauss-Legendre rule of n nodes: exact for polynomials up to degree 2n - 1. Nodes by Newton's method on the
/// Legendre polynomial (Press et al., Numerical Recipes, 3rd ed., 4.6.1).
QuadratureRule gauss_legendre(int n);

}  // namespace uniquadric
