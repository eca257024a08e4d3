#include "evaluation/iou/disc_ellipse.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

using std::numbers::pi;
using Point = Eigen::Vector2d;
constexpr int kMaxSteps = 100;
// Newton's method squares its error, so the last step is about the square root of what is left.
constexpr double kStationaryStep =
    1e-4;  // rad: leaves 1e-8, at which the distance, flat there, is right to 1e-16
constexpr double kCrossingStep = 1e-8;  // rad: leaves 1e-16

// An ellipse with center.x, center.y >= 0 and major >= minor. Its point at parameter t is center + (major cos
// t, minor sin t); `excess` is the squared distance of that point from the origin, less 1.
struct QuadrantEllipse {
  double cx, cy, major, minor;
  struct Value {
    double f, slope;
  };

  Point point(double t) const { return {cx + major * std::cos(t), cy + minor * std::sin(t)}; }
  Value excess(double t) const {
    const double c = std::cos(t), s = std::sin(t);
    const double x = cx + major * c, y = cy + minor * s;
    return {x * x + y * y - 1, 2 * (y * minor * c - x * major * s)};
  }
  // Half the slope of `excess`, and the slope of that.
  Value slope(double t) const {
    const double c = std::cos(t), s = std::sin(t);
    const double a = (major - minor) * (major + minor);
    return {cy * minor * c - cx * major * s - a * c * s,
            -cy * minor * s - cx * major * c - a * (c * c - s * s)};
  }
};

// Where `f` changes sign between lo and hi, from positive to negative or the other way: Newton's method from
// `guess` that falls back to bisection. Without a change the result is the end at which one would be.
template <typename F>
double sign_change(double lo, double hi, double guess, bool positive_first, double last_step, const F& f) {
  double t = guess > lo && guess < hi ? guess : (lo + hi) / 2;
  double width = hi - lo;
  for (int i = 0; i < kMaxSteps && hi - lo > last_step * last_step; ++i) {
    const auto [value, slope] = f(t);
    ((value > 0) == positive_first ? lo : hi) = t;
    const double newton = t - value / slope;
    const bool usable = newton > lo && newton < hi;  // false for NaN
    if (usable && std::abs(newton - t) <= last_step) return newton;
    // Newton creeps along one end where the function is nearly flat: then halve.
    const bool creeping = i % 3 == 2 && hi - lo > width / 2;
    if (i % 3 == 2) width = hi - lo;
    t = usable && !creeping ? newton : (lo + hi) / 2;
  }
  return t;
}

// Extrema of the distance from the origin, by t, from the farthest point (first quadrant) round to it again:
// max, [min, max,] min, max. The two in brackets exist when the origin lies within the ellipse's evolute;
// they lie in the second quadrant, parted by the minimum of a convex function.
struct Extrema {
  std::array<double, 5> t{};
  int size = 0;
};
Extrema distance_extrema(const QuadrantEllipse& e) {
  const double a = (e.major - e.minor) * (e.major + e.minor);
  const double x = e.cx * e.major, y = e.cy * e.minor;
  const auto find = [&](double lo, double hi, double guess, bool positive_first) {
    return sign_change(lo, hi, guess, positive_first, kStationaryStep, [&](double t) { return e.slope(t); });
  };
  Extrema extrema;
  const auto add = [&](double t) { extrema.t[extrema.size++] = t; };
  const double farthest = find(0, pi / 2, std::atan2(y, x + a), true);
  add(farthest);
  const double px = std::cbrt(x), py = std::cbrt(y);
  const double evolute = px * px + py * py;
  if (evolute * evolute * evolute < a * a) {
    const double between = px == 0 && py == 0 ? pi / 4 : std::atan2(py, px);
    add(find(pi / 2, pi - between, pi / 2, false));
    add(find(pi - between, pi, pi, true));
  }
  const double across = std::max(x - a, 0.0);  // towards the minor axis' end when the ellipse is long
  add(find(pi, 3 * pi / 2, pi + std::atan2(y, across), false));
  add(farthest + 2 * pi);
  return extrema;
}

// Between two neighbouring extrema the squared distance runs about like a cosine; so the guess.
double crossing(const QuadrantEllipse& e, double lo, double hi, double at_lo, double at_hi) {
  const double guess = lo + (hi - lo) / pi * std::acos(-(at_lo + at_hi) / (at_lo - at_hi));
  return sign_change(lo, hi, guess, at_lo > 0, kCrossingStep, [&](double t) { return e.excess(t); });
}

// Area between an arc of the unit circle and its chord; angle in [0, 2 pi].
double segment(double angle) {
  if (angle > 1e-2) return (angle - std::sin(angle)) / 2;
  const double a2 = angle * angle;
  return angle * a2 / 12 * (1 - a2 / 20 * (1 - a2 / 42));
}

// Angle from a to b on the unit circle, counter-clockwise; of two that cannot be told apart by rounding, 0 or
// 2 pi, the caller says which.
double arc(const Point& a, const Point& b, bool nearly_whole) {
  constexpr double kRounding =
      1e-6;  // rad: crossings near a tangency are this uncertain, their segment is 1e-19
  const double angle = std::atan2(a.x() * b.y() - a.y() * b.x(), a.dot(b));
  if (std::abs(angle) < kRounding) return nearly_whole ? 2 * pi - std::abs(angle) : std::abs(angle);
  return angle < 0 ? angle + 2 * pi : angle;
}

double cross(const Point& a, const Point& b) {
  return a.x() * b.y() - a.y() * b.x();
}

// Crossings come as pairs: into the disc, out of it. The common region is bounded by the ellipse's arcs
// inside the disc and the circle's arcs from each way out to the next way in.
double area_between(const QuadrantEllipse& e, const std::array<double, 4>& crossings, int count) {
  std::array<Point, 4> p;
  for (int i = 0; i < count; ++i) p[i] = e.point(crossings[i]);
  const auto contains = [&](const Point& q) {
    return std::hypot((q.x() - e.cx) / e.major, (q.y() - e.cy) / e.minor) < 1;
  };
  double area = 0;
  for (int i = 0; i < count; i += 2) {
    const Point& out = p[i + 1];
    const Point& next_in = p[(i + 2) % count];
    area += e.major * e.minor * segment(crossings[i + 1] - crossings[i]);
    area += segment(arc(out, next_in, count == 2 && contains(-out)));
  }
  if (count == 4) area += cross(p[2] - p[0], p[3] - p[1]) / 2;
  return area;
}

}  // namespace

DiscIntersection intersect_unit_disc(const Eigen::Vector2d& center, const Eigen::Vector2d& semi_axes) {
  QuadrantEllipse e{std::abs(center.x()), std::abs(center.y()), semi_axes.x(), semi_axes.y()};
  if (e.major < e.minor) e = {e.cy, e.cx, e.minor, e.major};
  if (e.cx >= 1 + e.major || e.cy >= 1 + e.minor) return {DiscOverlap::disjoint, 0};
  const Extrema extrema = distance_extrema(e);
  std::array<double, 5> excess{};
  for (int i = 0; i < extrema.size; ++i) excess[i] = e.excess(extrema.t[i]).f;
  excess[extrema.size - 1] = excess[0];  // one point; signs must not differ by rounding
  if (excess[0] <= 0) return {DiscOverlap::ellipse_inside, pi * e.major * e.minor};
  if (excess[extrema.size - 2] >= 0) {
    const bool origin_inside = std::hypot(e.cx / e.major, e.cy / e.minor) < 1;
    return origin_inside ? DiscIntersection{DiscOverlap::disc_inside, pi}
                         : DiscIntersection{DiscOverlap::disjoint, 0};
  }
  std::array<double, 4> crossings{};
  int count = 0;
  for (int i = 0; i + 1 < extrema.size; ++i) {
    if ((excess[i] > 0) == (excess[i + 1] > 0)) continue;
    crossings[count++] = crossing(e, extrema.t[i], extrema.t[i + 1], excess[i], excess[i + 1]);
  }
  const double area =
      std::clamp(area_between(e, crossings, count), 0.0, pi * std::min(1.0, e.major * e.minor));
  return {count == 2 ? DiscOverlap::two_points : DiscOverlap::four_points, area};
}

}  // namespace uniquadric
