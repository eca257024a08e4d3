#pragma once

#include <cmath>

namespace uniquadric {

template <typename T>
T superellipsoid_support(const Eigen::Matrix<T, 3, 1>& semi_axes_m, const T& q,
                         const Eigen::Matrix<T, 3, 1>& normal, double smoothing_m) {
  using std::abs;
  using std::pow;
  using std::sqrt;
  Eigen::Matrix<T, 3, 1> v = semi_axes_m.cwiseProduct(normal);
  T largest(0);
  for (int i = 0; i < 3; ++i) {
    v[i] = smoothing_m > 0 ? sqrt(v[i] * v[i] + T(smoothing_m * smoothing_m)) - T(smoothing_m) : abs(v[i]);
    if (v[i] > largest) largest = v[i];
  }
  if (!(largest > T(0))) return T(0);
  T sum(0);  // scaled by the largest component: no overflow and no underflow
  for (int i = 0; i < 3; ++i)
    if (v[i] > T(0)) sum += pow(v[i] / largest, q);
  return largest * pow(sum, T(1) / q);
}

}  // namespace uniquadric
