#include "evaluation/iou/gauss_legendre.h"

#include <cmath>
#include <numbers>

namespace uniquadric {

QuadratureRule gauss_legendre(int n) {
  constexpr int kNewtonSteps = 8;  // quadratic from a start that is good to 1e-2
  QuadratureRule rule;
  for (int i = 0; i < n; ++i) {
    double x = -std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double slope = 0;
    for (int step = 0; step < kNewtonSteps; ++step) {
      double p = 1, previous = 0;
      for (int k = 1; k <= n; ++k) {
        const double older = previous;
        previous = p;
        p = ((2 * k - 1) * x * previous - (k - 1) * older) / k;
      }
      slope = n * (x * p - previous) / (x * x - 1);
      x -= p / slope;
    }
    rule.nodes.push_back(x);
    rule.weights.push_back(2 / ((1 - x * x) * slope * slope));
  }
  return rule;
}

}  // namespace uniquadric
