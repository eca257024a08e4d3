#include "estimator/factors/surface_point.h"

#include <ceres/autodiff_cost_function.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>

namespace uniquadric {
namespace {

// The p-norm of two non-negative numbers and its derivatives by them.
template <typename T>
struct PairGauge {
  T value, by_u, by_v;
};

template <typename T>
PairGauge<T> pair_gauge(const T& u, const T& v, const T& p) {
  if (v > u) {
    const PairGauge<T> turned = pair_gauge(v, u, p);
    return {turned.value, turned.by_v, turned.by_u};
  }
  if (!(v > T(0))) return {u, T(u > T(0) ? 1 : 0), T(0)};
  const T ratio = v / u;
  const T power = pow(ratio, p);
  const T value = u * pow(T(1) + power, T(1) / p);
  const T by_u = value / (u * (T(1) + power));
  return {value, by_u, by_u * power / ratio};
}

template <int Exponents>
class SurfacePoint {
 public:
  SurfacePoint(const Eigen::Vector3d& point, double sigma_m) : point_(point), sigma_m_(sigma_m) {}

  template <typename T>
  bool operator()(const T* body_from_shape, const T* log_axes, const T* exponents, T* residual) const {
    using std::abs;
    using std::exp;
    using std::sqrt;
    const Eigen::Map<const Eigen::Quaternion<T>> q(body_from_shape);
    const Eigen::Map<const Eigen::Matrix<T, 3, 1>> t(body_from_shape + 4);
    const Eigen::Matrix<T, 3, 1> x = q.conjugate() * (point_.cast<T>() - t);
    // 1/p = 1 - 1/q and q = 1 + 1 / (1 + exp(-s)) give p = 2 + exp(-s).
    const int profile = Exponents == 1 ? 0 : (x.z() > T(0) ? 1 : 2);
    const T p_outline = T(2) + exp(-exponents[0]), p_profile = T(2) + exp(-exponents[profile]);
    Eigen::Matrix<T, 3, 1> inverse_axes, u;
    for (int i = 0; i < 3; ++i) {
      inverse_axes[i] = exp(-log_axes[i]);
      u[i] = abs(x[i]) * inverse_axes[i];
    }
    const PairGauge<T> outline = pair_gauge<T>(u[0], u[1], p_outline);
    const PairGauge<T> whole = pair_gauge<T>(outline.value, u[2], p_profile);
    const Eigen::Matrix<T, 3, 1> gradient =
        Eigen::Matrix<T, 3, 1>(whole.by_u * outline.by_u, whole.by_u * outline.by_v, whole.by_v)
            .cwiseProduct(inverse_axes);
    const T slope = gradient.squaredNorm();
    if (!(slope > T(0))) {  // the very centre, where no direction leads to the surface
      residual[0] = T(-1 / sigma_m_) * exp(*std::min_element(log_axes, log_axes + 3));
      return true;
    }
    residual[0] = (whole.value - T(1)) / sqrt(slope) / T(sigma_m_);
    return true;
  }

 private:
  Eigen::Vector3d point_;
  double sigma_m_;
};

template <int Exponents>
std::unique_ptr<ceres::CostFunction> make(const Eigen::Vector3d& point, double sigma_m) {
  using Cost = ceres::AutoDiffCostFunction<SurfacePoint<Exponents>, 1, 7, 3, Exponents>;
  return std::make_unique<Cost>(new SurfacePoint<Exponents>(point, sigma_m));
}

}  // namespace

std::unique_ptr<ceres::CostFunction> surface_point_factor(const Eigen::Vector3d& point_in_body_m,
                                                          double sigma_m, int exponents) {
  assert(exponents == 1 || exponents == 3);
  return exponents == 3 ? make<3>(point_in_body_m, sigma_m) : make<1>(point_in_body_m, sigma_m);
}

}  // namespace uniquadric
