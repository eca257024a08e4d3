#pragma once

#include <cmath>

namespace uniquadric {

/// A scalar function of time at one instant, with its first and second derivative: formulas written in jets
/// carry their derivatives along (automatic differentiation, forward mode, second order).
struct Jet {
  double value = 0, rate = 0, acceleration = 0;
};

/// Time itself.
inline Jet time_jet(double time_s) {
  return {time_s, 1, 0};
}

inline Jet operator+(const Jet& a, const Jet& b) {
  return {a.value + b.value, a.rate + b.rate, a.acceleration + b.acceleration};
}
inline Jet operator+(double a, const Jet& b) {
  return {a + b.value, b.rate, b.acceleration};
}
inline Jet operator*(double a, const Jet& b) {
  return {a * b.value, a * b.rate, a * b.acceleration};
}
inline Jet operator*(const Jet& a, const Jet& b) {
  return {a.value * b.value, a.rate * b.value + a.value * b.rate,
          a.acceleration * b.value + 2 * a.rate * b.rate + a.value * b.acceleration};
}

inline Jet sin(const Jet& a) {
  const double s = std::sin(a.value), c = std::cos(a.value);
  return {s, c * a.rate, c * a.acceleration - s * a.rate * a.rate};
}

/// Length of (a, b), which must not be 0.
inline Jet hypot(const Jet& a, const Jet& b) {
  const double length = std::hypot(a.value, b.value);
  const Jet square = a * a + b * b;
  const double rate = square.rate / (2 * length);
  return {length, rate, (square.acceleration / 2 - rate * rate) / length};
}

/// Angle of (x, y), which must not be (0, 0).
inline Jet atan2(const Jet& y, const Jet& x) {
  const double square = x.value * x.value + y.value * y.value;
  const double rate = (x.value * y.rate - y.value * x.rate) / square;
  const double swept = x.value * y.acceleration - y.value * x.acceleration;
  const double growth = 2 * (x.value * x.rate + y.value * y.rate);
  return {std::atan2(y.value, x.value), rate, (swept - growth * rate) / square};
}

}  // namespace uniquadric
