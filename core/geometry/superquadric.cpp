#include "core/geometry/superquadric.h"

#include <cmath>

namespace uniquadric {
namespace {

// The q-norm of two non-negative numbers with its derivatives by them and by q.
struct PairNorm {
  double value = 0, by_u = 0, by_v = 0, by_q = 0;
};

PairNorm pair_norm(double u, double v, double q) {
  const bool u_larger = u >= v;
  const double large = u_larger ? u : v, small = u_larger ? v : u;
  if (!(large > 0)) return {};
  const double ratio = small / large;
  const double log_ratio = ratio > 0 ? std::log(ratio) : 0;
  const double power = ratio > 0 ? std::exp(q * log_ratio) : 0;  // ratio^q
  const double sum = 1 + power, log_sum = std::log1p(power);
  PairNorm n;
  n.value = large * std::exp(log_sum / q);
  const double by_large = n.value / (large * sum);
  // At ratio 0 the derivative is 0 for every q > 1 and 1 for the box's q = 1.
  const double by_small = ratio > 0 ? by_large * power / ratio : (q > 1 ? 0 : 1);
  n.by_u = u_larger ? by_large : by_small;
  n.by_v = u_larger ? by_small : by_large;
  n.by_q = n.value / q * (power * log_ratio / sum - log_sum / q);
  return n;
}

// The norms that the gauge is made of: of the outline, and of it with the profile.
struct GaugeNorms {
  PairNorm outline, whole;
};

GaugeNorms gauge_norms(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                       const Eigen::Vector3d& point) {
  const auto dual = [](double exponent) { return exponent / (exponent - 1); };
  const Eigen::Vector3d u = point.cwiseQuotient(semi_axes_m).cwiseAbs();
  const PairNorm outline = pair_norm(u.x(), u.y(), dual(q.outline));
  return {outline, pair_norm(outline.value, u.z(), dual(point.z() > 0 ? q.upper : q.lower))};
}

// The axes that are x, y and z to the exponents.
Eigen::Vector3i named_axes(int profile_axis) {
  return {(profile_axis + 1) % 3, (profile_axis + 2) % 3, profile_axis};
}

}  // namespace

Eigen::Vector3d superellipsoid_support_point(const Eigen::Vector3d& semi_axes_m, double q,
                                             const Eigen::Vector3d& normal) {
  const double h = superellipsoid_support<double>(semi_axes_m, q, normal);
  Eigen::Vector3d point;
  for (int i = 0; i < 3; ++i) {
    const double v = semi_axes_m[i] * normal[i];
    point[i] = h > 0 ? semi_axes_m[i] * std::copysign(std::pow(std::abs(v) / h, q - 1), v) : 0.0;
  }
  return point;
}

// Dirichlet's integral: V = 8 a b c Gamma(1 + 1/p)^3 / Gamma(1 + 3/p), with 1/p = 1 - 1/q.
double superellipsoid_volume(const Eigen::Vector3d& semi_axes_m, double q) {
  const double inverse_p = 1 - 1 / q;
  return 8 * semi_axes_m.prod() * std::pow(std::tgamma(1 + inverse_p), 3) / std::tgamma(1 + 3 * inverse_p);
}

SupportDerivatives superellipsoid_support_derivatives(const Eigen::Vector3d& semi_axes_m,
                                                      const SuperExponents& q, const Eigen::Vector3d& normal,
                                                      double smoothing_m) {
  const Eigen::Vector3d v = semi_axes_m.cwiseProduct(normal);
  Eigen::Vector3d u, slope;  // |v| and its derivative
  for (int i = 0; i < 3; ++i) {
    const double root = smoothing_m > 0 ? std::hypot(v[i], smoothing_m) : std::abs(v[i]);
    u[i] = smoothing_m > 0 ? root - smoothing_m : root;
    slope[i] = root > 0 ? v[i] / root : 0;
  }
  SupportDerivatives d;
  d.upper = normal.z() > 0;
  const PairNorm outline = pair_norm(u.x(), u.y(), q.outline);
  const PairNorm whole = pair_norm(outline.value, u.z(), d.upper ? q.upper : q.lower);
  d.value = whole.value;
  d.by_outline = whole.by_u * outline.by_q;
  d.by_profile = whole.by_q;
  const Eigen::Vector3d by_u(whole.by_u * outline.by_u, whole.by_u * outline.by_v, whole.by_v);
  d.by_normal = by_u.cwiseProduct(slope).cwiseProduct(semi_axes_m);
  d.by_log_axes = d.by_normal.cwiseProduct(normal);
  return d;
}

double superellipsoid_support(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                              const Eigen::Vector3d& normal, double smoothing_m) {
  return superellipsoid_support_derivatives(semi_axes_m, q, normal, smoothing_m).value;
}

// The cross-section at height z is the outline scaled by (1 - z^p)^(1/p): its area, integrated, is a beta
// function.
double superellipsoid_volume(const Superellipsoid& body) {
  const auto inverse_p = [](double q) { return 1 - 1 / q; };
  const double s = inverse_p(body.exponents.outline);
  const double outline_area = 4 * std::pow(std::tgamma(1 + s), 2) / std::tgamma(1 + 2 * s);
  const auto height = [&](double q) {
    const double t = inverse_p(q);
    return std::tgamma(1 + t) * std::tgamma(1 + 2 * t) / std::tgamma(1 + 3 * t);
  };
  return body.semi_axes_m.prod() * outline_area *
         (height(body.exponents.upper) + height(body.exponents.lower));
}

Eigen::Vector3d support_point(const Superellipsoid& body, const Eigen::Vector3d& normal) {
  const Eigen::Vector3i named = named_axes(body.profile_axis);
  Eigen::Vector3d point;
  point(named) =
      superellipsoid_support_derivatives(body.semi_axes_m(named), body.exponents, normal(named)).by_normal;
  return point;
}

double gauge(const Superellipsoid& body, const Eigen::Vector3d& point) {
  const Eigen::Vector3i named = named_axes(body.profile_axis);
  return superellipsoid_gauge(body.semi_axes_m(named), body.exponents, point(named));
}

Eigen::Vector3d normal_at(const Superellipsoid& body, const Eigen::Vector3d& point) {
  const Eigen::Vector3i named = named_axes(body.profile_axis);
  Eigen::Vector3d normal;
  normal(named) = superellipsoid_normal(body.semi_axes_m(named), body.exponents, point(named));
  return normal;
}

double superellipsoid_gauge(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                            const Eigen::Vector3d& point) {
  return gauge_norms(semi_axes_m, q, point).whole.value;
}

Eigen::Vector3d superellipsoid_normal(const Eigen::Vector3d& semi_axes_m, const SuperExponents& q,
                                      const Eigen::Vector3d& point) {
  const GaugeNorms norms = gauge_norms(semi_axes_m, q, point);
  const Eigen::Vector3d slope(norms.whole.by_u * norms.outline.by_u, norms.whole.by_u * norms.outline.by_v,
                              norms.whole.by_v);
  return slope.cwiseProduct(point.cwiseSign()).cwiseQuotient(semi_axes_m).normalized();
}

}  // namespace uniquadric
