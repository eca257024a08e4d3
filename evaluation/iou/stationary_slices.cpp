#include "evaluation/iou/stationary_slices.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace uniquadric {
namespace {

constexpr int kBisections = 60;

// Stationary points are y_i = c_i m / (a_i^2 + m) for the roots m of  sum a_i^2 c_i^2 / (a_i^2 + m)^2 = 1.
struct Secular {
  Eigen::Array3d c, a2;

  double operator()(double m) const { return (a2 * c.square() / (a2 + m).square()).sum() - 1; }
  double slope(double m) const { return -2 * (a2 * c.square() / (a2 + m).cube()).sum(); }
  double z(double m) const { return c[2] * m / (a2[2] + m); }
};

// Bisects [low, high] until `left(m)` turns false.
template <typename Predicate>
double bisect(double low, double high, const Predicate& left) {
  for (int i = 0; i < kBisections; ++i) {
    const double middle = (low + high) / 2;
    (left(middle) ? low : high) = middle;
  }
  return (low + high) / 2;
}

}  // namespace

std::vector<double> stationary_slices(const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes) {
  const Secular f{center.array(), semi_axes.array().square()};
  std::vector<double> heights;
  // Beyond the outer poles the sum falls from infinity to zero: |m + a_i^2| <= sqrt(3) max |a_i c_i| at the
  // root.
  std::array<double, 3> poles = {-f.a2[0], -f.a2[1], -f.a2[2]};
  std::sort(poles.begin(), poles.end());
  const double reach = 2 * (semi_axes.array() * f.c.abs()).maxCoeff();
  heights.push_back(f.z(bisect(poles[2], poles[2] + reach, [&](double m) { return f(m) > 0; })));
  heights.push_back(f.z(bisect(poles[0] - reach, poles[0], [&](double m) { return f(m) < 0; })));
  for (int i = 0; i < 2; ++i) {  // between two poles the sum is convex: no root or two
    const double lowest = bisect(poles[i], poles[i + 1], [&](double m) { return f.slope(m) < 0; });
    if (!(f(lowest) < 0)) continue;
    heights.push_back(f.z(bisect(poles[i], lowest, [&](double m) { return f(m) > 0; })));
    heights.push_back(f.z(bisect(lowest, poles[i + 1], [&](double m) { return f(m) < 0; })));
  }
  // A centre that lies on a plane of symmetry takes its pole away and leaves points with m at the pole.
  for (int i = 0; i < 2; ++i) heights.push_back(f.z(-f.a2[i]));
  double rest = 1;
  for (int i = 0; i < 2; ++i) rest -= f.a2[i] * std::pow(f.c[i] / (f.a2[i] - f.a2[2]), 2);
  if (rest > 0)
    for (const int side : {-1, 1}) heights.push_back(f.c[2] + side * semi_axes[2] * std::sqrt(rest));
  std::erase_if(heights, [](double z) { return !std::isfinite(z); });
  return heights;
}

}  // namespace uniquadric
