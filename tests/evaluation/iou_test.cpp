#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "evaluation/iou/count_inside_parts.h"
#include "evaluation/iou/disc_ellipse.h"
#include "evaluation/iou/ellipsoid_iou.h"
#include "evaluation/iou/monte_carlo.h"
#include "tests/evaluation/random_ellipsoid.h"

namespace uniquadric {
namespace {
using std::numbers::pi;

constexpr double kExact = 1e-6;       // the promised error of the exact IoU
constexpr double kClosedForm = 1e-9;  // what the quadrature reaches where nothing is degenerate

Ellipsoid ball(double radius_m, const Eigen::Vector3d& center = Eigen::Vector3d::Zero()) {
  return {{Eigen::Quaterniond::Identity(), center}, Eigen::Vector3d::Constant(radius_m)};
}

Ellipsoid at(const Eigen::Vector3d& center, const Eigen::Vector3d& semi_axes) {
  return {{Eigen::Quaterniond::Identity(), center}, semi_axes};
}

// Two balls at distance d share a lens (Weisstein, "Sphere-Sphere Intersection").
double balls_iou(double R, double r, double d) {
  const double lens = pi * std::pow(R + r - d, 2) *
                      (d * d + 2 * d * r - 3 * r * r + 2 * d * R + 6 * r * R - 3 * R * R) / (12 * d);
  return lens / (4 * pi / 3 * (R * R * R + r * r * r) - lens);
}

// Second way, chords instead of slices: over the shadow of the ball that `a` is whitened to, the length that
// a line along x has in both bodies. Midpoint rule on n x 2n polar cells; rows of the shadow are shared with
// no code of ours.
double chord_iou(const Ellipsoid& a, const Ellipsoid& b, int n) {
  const Eigen::Matrix3d Ra = a.world_from_object.rotation.toRotationMatrix();
  const Eigen::Matrix3d Rb = b.world_from_object.rotation.toRotationMatrix();
  const Eigen::Matrix3d to_b = b.semi_axes_m.cwiseInverse().asDiagonal() * Rb.transpose();
  const Eigen::Matrix3d W = to_b * Ra * a.semi_axes_m.asDiagonal();
  const Eigen::Vector3d o = to_b * (a.world_from_object.translation - b.world_from_object.translation);
  // |p + x u|^2 = 1 along the line, p = o + y v + z w: all its products beforehand, the loop in plain numbers
  const Eigen::Vector3d u = W.col(0), v = W.col(1), w = W.col(2);
  const double uu = u.dot(u), uo = u.dot(o), uv = u.dot(v), uw = u.dot(w), oo = o.dot(o) - 1, ov = o.dot(v);
  const double ow = o.dot(w), vv = v.dot(v), vw = v.dot(w), ww = w.dot(w);
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    const double angle = pi / 2 * (i + 0.5) / n, rho = std::sin(angle), half = std::cos(angle);
    for (int j = 0; j < 2 * n; ++j) {
      const double y = rho * std::cos(pi * (j + 0.5) / n), z = rho * std::sin(pi * (j + 0.5) / n);
      const double B = uo + y * uv + z * uw;
      const double D = B * B - uu * (oo + y * (2 * ov + y * vv + 2 * z * vw) + z * (2 * ow + z * ww));
      if (D <= 0) continue;
      const double low = std::max(-half, (-B - std::sqrt(D)) / uu),
                   high = std::min(half, (-B + std::sqrt(D)) / uu);
      sum += std::max(0.0, high - low) * rho * half;
    }
  }
  const double common = sum * (pi / 2 / n) * (pi / n) * a.semi_axes_m.prod();
  return common / (4 * pi / 3 * (a.semi_axes_m.prod() + b.semi_axes_m.prod()) - common);
}

}  // namespace

TEST(DiscEllipse, AgreesWithQuadratureOverAllTopologies) {
  RandomStream random(1, "disc");
  std::array<int, 5> seen{};
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d c(random.uniform(-1, 1), random.uniform(-1, 1));
    const Eigen::Vector2d a(std::exp(random.uniform(-2, 1)), std::exp(random.uniform(-2, 1)));
    const auto [overlap, area] =
        intersect_unit_disc(i % 3 == 0 ? Eigen::Vector2d(0.1 * c) : Eigen::Vector2d(1.5 * c), a);
    ++seen[static_cast<std::size_t>(overlap)];
    const Eigen::Vector2d center = i % 3 == 0 ? 0.1 * c : 1.5 * c;
    const double low = std::max(-1.0, center.y() - a.y()), high = std::min(1.0, center.y() + a.y());
    double sum = 0;  // rows of both, midpoint rule in the angle
    constexpr int kRows = 2000;
    for (int k = 0; k < kRows && low < high; ++k) {
      const double t = pi * (k + 0.5) / kRows, y = (low + high) / 2 + (high - low) / 2 * std::cos(t);
      const double v = (y - center.y()) / a.y();
      const double half = a.x() * std::sqrt(std::max(0.0, 1 - v * v)), disc = std::sqrt(1 - y * y);
      const double width = std::min(center.x() + half, disc) - std::max(center.x() - half, -disc);
      sum += std::max(0.0, width) * (high - low) / 2 * std::sin(t);
    }
    constexpr double kRowError = 5e-6;  // kinks of the width within 2000 rows
    ASSERT_NEAR(area, sum * pi / kRows, kRowError) << "case " << i;
  }
  for (const int count : seen) EXPECT_GT(count, 30);
}

TEST(EllipsoidIou, TwoBallsShareALens) {
  int cases = 0;
  for (const double r : {1.0, 0.7, 0.1, 0.01})
    for (const double share : {1e-6, 0.01, 0.3, 0.5, 0.9, 0.999999}) {
      const double d = 1 - r + 2 * r * share;
      if (d == 0) continue;
      EXPECT_NEAR(ellipsoid_iou(ball(1), ball(r, d * Eigen::Vector3d(0.6, 0, 0.8))), balls_iou(1, r, d),
                  kClosedForm);
      ++cases;
    }
  EXPECT_EQ(cases, 24);
}

TEST(EllipsoidIou, AlignedEllipsoidsAreBallsUnderAnAffineMap) {
  const Eigen::Vector3d axes(100, 1, 3);
  const Eigen::Vector3d shift = 0.8 * Eigen::Vector3d(1, 2, 2) / 3;
  const double expected = balls_iou(1, 0.5, 0.8);
  EXPECT_NEAR(ellipsoid_iou(at({0, 0, 0}, axes), at(shift.cwiseProduct(axes), 0.5 * axes)), expected,
              kClosedForm);
}

TEST(EllipsoidIou, IdenticalIsExactlyOneWhereverItIs) {
  RandomStream random(2, "identical");
  for (int i = 0; i < 200; ++i) {
    Ellipsoid e = random_ellipsoid(random, 1e4, 1e4);
    EXPECT_EQ(ellipsoid_iou(e, e), 1.0);
    Ellipsoid negated = e;
    negated.world_from_object.rotation.coeffs() *= -1;
    EXPECT_EQ(ellipsoid_iou(e, negated), 1.0);
  }
  Ellipsoid turned = ball(0.3, {1, 2, 3});
  turned.world_from_object.rotation = random_rotation(random);
  EXPECT_EQ(ellipsoid_iou(turned, ball(0.3, {1, 2, 3})), 1.0);
}

TEST(EllipsoidIou, NestedIsTheVolumeRatio) {
  RandomStream random(3, "nested");
  for (int i = 0; i < 50; ++i) {
    const Ellipsoid inner = random_ellipsoid(random, 0, 100);
    EXPECT_NEAR(ellipsoid_iou(inner, ball(10)), inner.semi_axes_m.prod() / 1e3, kClosedForm);
    Ellipsoid scaled = inner;  // one centre, one shape
    scaled.semi_axes_m *= 0.9;
    EXPECT_NEAR(ellipsoid_iou(inner, scaled), 0.729, kClosedForm);
  }
  // touching from within, at one point and along a circle
  EXPECT_NEAR(ellipsoid_iou(ball(1), ball(0.5, {0.5, 0, 0})), 0.125, kClosedForm);
  EXPECT_NEAR(ellipsoid_iou(ball(1), at({0, 0, 0}, {1, 1, 0.25})), 0.25, kClosedForm);
  EXPECT_NEAR(ellipsoid_iou(ball(1), at({0, 0, 0}, {1, 0.1, 0.1})), 0.01, kClosedForm);
}

TEST(EllipsoidIou, DisjointAndTouchingFromOutsideIsZero) {
  EXPECT_EQ(ellipsoid_iou(ball(1), ball(1, {3, 0, 0})), 0);
  EXPECT_EQ(ellipsoid_iou(ball(1), ball(1, {2, 0, 0})), 0);
  EXPECT_NEAR(ellipsoid_iou(at({0, 0, 0}, {1, 100, 1}), at({2, 0, 0}, {1, 1, 100})), 0, kClosedForm);
}

TEST(EllipsoidIou, AgreesWithIntegrationOverChords) {
  RandomStream random(4, "chords");
  constexpr int kCells = 1200;  // their own error is 3e-7 at most, falling with their number
  int partial = 0;
  for (int i = 0; i < 10; ++i) {
    const double ratio = i % 3 == 0 ? 1.5 : i % 3 == 1 ? 6 : 30;
    const Ellipsoid a = random_ellipsoid(random, 0.25, ratio), b = random_ellipsoid(random, 0.25, ratio);
    const double iou = ellipsoid_iou(a, b);
    partial += iou > 0 ? 1 : 0;
    EXPECT_NEAR(iou, chord_iou(a, b, kCells), kExact) << "case " << i;
  }
  EXPECT_EQ(partial, 10);
}

TEST(EllipsoidIou, ThinCrossedNeedlesAgreeWithTheirSeries) {
  // Needles (1, e, e) and (e, 1, e) crossed at their centres: near the crossing both are cylinders of radius
  // e, whose common volume is 16 e^3 / 3 (Steinmetz); the needles' curvature changes that by the order e^2.
  constexpr double e = 0.01;
  const double common = 16 * e * e * e / 3, all = 2 * 4 * pi / 3 * e * e - common;
  constexpr double kOrderE2 = 2e-4;  // relative
  EXPECT_NEAR(ellipsoid_iou(at({0, 0, 0}, {1, e, e}), at({0, 0, 0}, {e, 1, e})), common / all,
              kOrderE2 * common / all);
}

TEST(EllipsoidIou, IsSymmetricInvariantAndFastForAnyPair) {
  RandomStream random(5, "laws");
  int positive = 0;
  for (int i = 0; i < 300; ++i) {
    const double ratio = i % 2 ? 3 : 1e4;
    const Ellipsoid a = random_ellipsoid(random, 0.3, ratio), b = random_ellipsoid(random, 0.3, ratio);
    const double iou = ellipsoid_iou(a, b);
    positive += iou > 0 ? 1 : 0;
    ASSERT_EQ(iou, ellipsoid_iou(b, a)) << "case " << i;
    const Pose move = {random_rotation(random), random_vector(random, 1e4)};
    const Ellipsoid far_a = {move * a.world_from_object, a.semi_axes_m},
                    far_b = {move * b.world_from_object, b.semi_axes_m};
    // 10 km away a double resolves 2e-12 m; the thinnest axis here is 1 cm.
    ASSERT_NEAR(iou, ellipsoid_iou(far_a, far_b), 1e-8) << "case " << i;
    Ellipsoid small_a = a, small_b = b;
    for (Ellipsoid* e : {&small_a, &small_b}) {
      e->semi_axes_m *= 1e-3;
      e->world_from_object.translation *= 1e-3;
    }
    ASSERT_NEAR(iou, ellipsoid_iou(small_a, small_b), 1e-8) << "case " << i;
  }
  EXPECT_GT(positive, 150);
}

TEST(EllipsoidIou, DecreasesAsBodiesPart) {
  double last = 1;
  for (int i = 1; i <= 200; ++i) {
    const double iou = ellipsoid_iou(at({0, 0, 0}, {1, 0.5, 0.2}), at({i * 0.01, 0, 0}, {1, 0.5, 0.2}));
    EXPECT_LT(iou, last) << i;
    last = iou;
  }
  EXPECT_EQ(last, 0);
}

TEST(MonteCarloIou, LiesWithinFiveStandardErrors) {
  const BallSamples samples(20'000, 7);
  RandomStream random(6, "monte carlo");
  for (int i = 0; i < 100; ++i) {
    const Ellipsoid a = random_ellipsoid(random, 0.3, i % 2 ? 3 : 300),
                    b = random_ellipsoid(random, 0.3, i % 2 ? 3 : 300);
    const auto [iou, error] = ellipsoid_iou_monte_carlo(a, b, samples);
    ASSERT_NEAR(iou, ellipsoid_iou(a, b), 5 * error) << "case " << i;
    ASSERT_LT(error, 0.01);
    ASSERT_EQ(iou, ellipsoid_iou_monte_carlo(b, a, samples).iou);
  }
  const Ellipsoid e = random_ellipsoid(random, 10, 3);
  EXPECT_EQ(ellipsoid_iou_monte_carlo(e, e, samples).iou, 1);
}

// Two balls of which so little is in common, or so little is not, that a few of the samples tell: those that
// happen to see less of it state a smaller error, too.
TEST(MonteCarloIou, StatesItsErrorWhereAFewSamplesDecide) {
  constexpr int kSeeds = 200, kSamples = 6400;
  // how far a ball of radius 10 is: dips into the unit ball or leaves a part of it out by as much; of the
  // samples this is 2, 5, 10 and 90
  const std::array<double, 8> distances = {11 - 0.02, 11 - 0.035, 11 - 0.05, 11 - 0.15,
                                           9 + 0.02,  9 + 0.035,  9 + 0.05,  9 + 0.15};
  std::array<double, 8> squares{};
  int beyond_3 = 0, few = 0;
  for (int seed = 0; seed < kSeeds; ++seed) {
    const BallSamples samples(kSamples, static_cast<std::uint64_t>(seed));
    for (std::size_t i = 0; i < distances.size(); ++i) {
      const auto [iou, error] = ellipsoid_iou_monte_carlo(ball(1), ball(10, {distances[i], 0, 0}), samples);
      const double z = (iou - balls_iou(10, 1, distances[i])) / error;
      EXPECT_LT(std::abs(z), 5) << "pair " << i << " seed " << seed;
      squares[i] += z * z / kSeeds;
      beyond_3 += std::abs(z) > 3;
      few += 1;
    }
  }
  EXPECT_EQ(few, 1600);
  EXPECT_LT(beyond_3, 0.01 * few);  // 0.0027 of normal errors
  for (const double square : squares) EXPECT_LT(square, 1.3);
  EXPECT_GT(squares[3], 0.7);  // and no larger than needed where some hundred samples are seen
  EXPECT_GT(squares[7], 0.7);
}

TEST(MonteCarloIou, CountsTheSameByAnyInstructions) {
  const CountInside by_four = count_inside_avx2();
  if (!by_four) GTEST_SKIP() << "this machine has no AVX2";
  const BallSamples samples(10'000, 5);
  RandomStream random(8, "instructions");
  std::int64_t inside = 0;
  for (int i = 0; i < 300; ++i) {
    Eigen::Vector3d center, axes;
    for (int k = 0; k < 3; ++k) {
      center[k] = random.uniform(-0.8, 0.8);
      axes[k] = random.uniform(0.01, 1);
    }
    const int n = samples.size() - i;  // ends that are no multiple of four
    const auto count = [&](CountInside function) {
      return function(samples.x().data(), samples.y().data(), samples.z().data(), n, center.data(),
                      axes.data());
    };
    ASSERT_EQ(count(by_four), count(count_inside_baseline)) << i;
    inside += count(by_four);
  }
  EXPECT_GT(inside, 300'000);
  EXPECT_LT(inside, 2'700'000);
  // points on the very edge: the last bit decides, and is the same
  const std::array<double, 5> x = {1, std::nextafter(1, 2), std::nextafter(1, 0), 0.6, 0.6},
                              y = {0, 0, 0, 0.8, 0.8}, z = {0, 0, 0, 0, 1e-9};
  const std::array<double, 3> none = {0, 0, 0}, unit = {1, 1, 1};
  for (const CountInside function : {by_four, CountInside(count_inside_baseline)})
    for (std::int64_t n = 0; n <= 5; ++n)
      EXPECT_EQ(function(x.data(), y.data(), z.data(), n, none.data(), unit.data()),
                (std::array<std::int64_t, 6>{0, 1, 1, 2, 3, 4}[static_cast<std::size_t>(n)]));
}

TEST(BallSamples, FillTheBallEvenlyAndRepeat) {
  const BallSamples samples(10'000, 3), again(10'000, 3), other(10'000, 4);
  EXPECT_GE(samples.size(), 10'000);
  EXPECT_EQ(samples.x(), again.x());
  EXPECT_EQ(samples.z(), again.z());
  EXPECT_NE(samples.x(), other.x());
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double square = 0;
  for (int i = 0; i < samples.size(); ++i) {
    const Eigen::Vector3d p = samples.point(i);
    ASSERT_LE(p.norm(), 1 + 1e-12);
    mean += p;
    square += p.squaredNorm();
  }
  const double n = static_cast<double>(samples.size());
  constexpr double kSpread = 5e-3;  // a hundredth of what one point could add by chance, times sqrt(n)
  EXPECT_LT((mean / n).norm(), kSpread);
  EXPECT_NEAR(square / n, 0.6, kSpread);  // E |x|^2 = 3/5 in the unit ball
}

}  // namespace uniquadric
