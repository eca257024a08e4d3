#include "core/geometry/superquadric.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const Eigen::Vector3d kAxes(0.7, 0.2, 0.4);

double support(double q, const Eigen::Vector3d& n, double smoothing = 0) {
  return superellipsoid_support<double>(kAxes, q, n, smoothing);
}

TEST(Superquadric, ExponentTwoIsTheEllipsoidAndOneTheBox) {
  const Eigen::Vector3d n = Eigen::Vector3d(1, -2, 0.5).normalized();
  EXPECT_NEAR(support(2, n), kAxes.cwiseProduct(n).norm(), 1e-15);
  EXPECT_NEAR(support(1, n), kAxes.dot(n.cwiseAbs()), 1e-15);
}

// The second way: the largest n . x over points of sum |x_i / a_i|^p = 1 found by sampling.
TEST(Superquadric, SupportIsTheLargestReachOfTheBody) {
  for (const double q : {1.2, 1.5, 1.9}) {
    const double p = q / (q - 1);
    const Eigen::Vector3d n = Eigen::Vector3d(0.3, 0.8, -0.5).normalized();
    double reach = 0;
    for (int i = 0; i <= 400; ++i)
      for (int j = 0; j < 800; ++j) {
        const double polar = i * std::numbers::pi / 400, around = j * std::numbers::pi / 400;
        const Eigen::Vector3d d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                std::cos(polar));
        const double size = std::pow(d.cwiseQuotient(kAxes).cwiseAbs().array().pow(p).sum(), 1 / p);
        reach = std::max(reach, n.dot(d) / size);
      }
    EXPECT_NEAR(support(q, n), reach, 2e-4);  // m, the sampling's step
    EXPECT_GE(support(q, n), reach - 1e-12);
  }
}

TEST(Superquadric, SupportPointLiesOnTheSurfaceAndTouchesThePlane) {
  for (const double q : {1.1, 1.5, 2.0}) {
    const double p = q / (q - 1);
    const Eigen::Vector3d n = Eigen::Vector3d(-0.3, 0.8, 0.2).normalized();
    const Eigen::Vector3d x = superellipsoid_support_point(kAxes, q, n);
    EXPECT_NEAR(x.cwiseQuotient(kAxes).cwiseAbs().array().pow(p).sum(), 1, 1e-10);
    EXPECT_NEAR(n.dot(x), support(q, n), 1e-12);
  }
}

TEST(Superquadric, SmoothingLowersTheSupportByLessThanItsSum) {
  const Eigen::Vector3d n = Eigen::Vector3d(1, 0, 0.1).normalized();
  EXPECT_LE(support(1.3, n, 1e-3), support(1.3, n));
  EXPECT_NEAR(support(1.3, n, 1e-3), support(1.3, n), 3e-3);
}

TEST(Superquadric, VolumeIsKnownAtBothEndsAndBySamplingBetween) {
  EXPECT_NEAR(superellipsoid_volume(kAxes, 2), 4.0 / 3 * std::numbers::pi * kAxes.prod(), 1e-14);
  EXPECT_NEAR(superellipsoid_volume(kAxes, 1), 8 * kAxes.prod(), 1e-14);
  RandomStream random(1, "volume");
  int inside = 0;
  constexpr int kSamples = 200'000;
  for (int i = 0; i < kSamples; ++i) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += std::pow(random.uniform(), 3.0);  // p = 3, q = 1.5
    inside += sum <= 1;
  }
  const double share = superellipsoid_volume(kAxes, 1.5) / (8 * kAxes.prod());
  EXPECT_NEAR(static_cast<double>(inside) / kSamples, share, 5 * std::sqrt(share * (1 - share) / kSamples));
}

Eigen::Vector3d random_normal(RandomStream& random) {
  return Eigen::Vector3d(random.normal(), random.normal(), random.normal()).normalized();
}

TEST(SuperExponents, EqualOnesAreTheSuperellipsoid) {
  RandomStream random(2, "normals");
  for (const double q : {1.0, 1.3, 1.7, 2.0})
    for (const double smoothing : {0.0, 1e-3})
      for (int i = 0; i < 50; ++i) {
        const Eigen::Vector3d n = random_normal(random);
        EXPECT_NEAR(superellipsoid_support(kAxes, {q, q, q}, n, smoothing), support(q, n, smoothing), 1e-15);
      }
}

TEST(SuperExponents, IsContinuousWhereTheProfileChangesAndHomogeneous) {
  const SuperExponents q{1.4, 1.9, 1.1};
  for (int i = 0; i < 12; ++i) {
    const Eigen::Vector3d flat(std::cos(i * 0.5), std::sin(i * 0.5), 0), up = 1e-9 * Eigen::Vector3d::UnitZ();
    EXPECT_NEAR(superellipsoid_support(kAxes, q, flat + up), superellipsoid_support(kAxes, q, flat - up),
                1e-9);
    const Eigen::Vector3d n(flat.x(), flat.y(), i % 2 ? 0.6 : -0.6);
    EXPECT_NEAR(superellipsoid_support(kAxes, q, 3 * n), 3 * superellipsoid_support(kAxes, q, n), 1e-14);
    EXPECT_NE(superellipsoid_support(kAxes, q, n), superellipsoid_support(kAxes, {1.4, 1.1, 1.9}, n));
  }
}

// A support function belongs to a body exactly when it is subadditive.
TEST(SuperExponents, IsConvex) {
  RandomStream random(3, "normals");
  for (int i = 0; i < 500; ++i) {
    const SuperExponents q{random.uniform(1, 2), random.uniform(1, 2), random.uniform(1, 2)};
    const Eigen::Vector3d a = random_normal(random), b = random_normal(random);
    EXPECT_LE(superellipsoid_support(kAxes, q, a + b),
              superellipsoid_support(kAxes, q, a) + superellipsoid_support(kAxes, q, b) + 1e-14);
  }
}

// The second way: points of the surface by the gauge; the largest n . x of them is h(n).
TEST(SuperExponents, SupportIsTheLargestReachOfTheGaugesBody) {
  const SuperExponents q{1.3, 1.8, 1.2};
  for (const Eigen::Vector3d& n : {Eigen::Vector3d(0.3, 0.8, -0.5), Eigen::Vector3d(-0.6, 0.2, 0.7)}) {
    double reach = 0;
    for (int i = 0; i <= 400; ++i)
      for (int j = 0; j < 800; ++j) {
        const double polar = i * std::numbers::pi / 400, around = j * std::numbers::pi / 400;
        const Eigen::Vector3d d(std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around),
                                std::cos(polar));
        reach = std::max(reach, n.dot(d) / superellipsoid_gauge(kAxes, q, d));
      }
    EXPECT_NEAR(superellipsoid_support(kAxes, q, n), reach, 2e-4);  // m, the sampling's step
    EXPECT_GE(superellipsoid_support(kAxes, q, n), reach - 1e-12);
  }
}

TEST(SuperExponents, SupportPointLiesOnTheSurfaceAndTouchesThePlane) {
  RandomStream random(5, "normals");
  for (int i = 0; i < 200; ++i) {
    const SuperExponents q{random.uniform(1.05, 2), random.uniform(1.05, 2), random.uniform(1.05, 2)};
    const Eigen::Vector3d n = random_normal(random);
    const auto d = superellipsoid_support_derivatives(kAxes, q, n);
    EXPECT_NEAR(superellipsoid_gauge(kAxes, q, d.by_normal), 1, 1e-10);
    EXPECT_NEAR(n.dot(d.by_normal), d.value, 1e-14);
    EXPECT_EQ(d.by_normal.z() > 0, d.upper);
  }
}

TEST(SuperExponents, AProfileAlongAnotherAxisIsTheSameBodyTurned) {
  constexpr double kAxes_m[] = {0.2, 0.3, 0.5}, kNormal[] = {0.4, -0.6, 0.7};
  const SuperExponents q{1.3, 1.1, 1.8};
  const Eigen::Vector3d along_z = support_point({Eigen::Map<const Eigen::Vector3d>(kAxes_m), q, 2},
                                                Eigen::Map<const Eigen::Vector3d>(kNormal));
  EXPECT_NEAR(superellipsoid_gauge(Eigen::Map<const Eigen::Vector3d>(kAxes_m), q, along_z), 1, 1e-12);
  for (const int axis : {0, 1}) {
    Eigen::Vector3d axes_m, normal, expected;
    for (int i = 0; i < 3; ++i) {  // what was z is `axis`, and so on around
      const int to = (axis + 1 + i) % 3;
      axes_m[to] = kAxes_m[i];
      normal[to] = kNormal[i];
      expected[to] = along_z[i];
    }
    EXPECT_EQ(support_point({axes_m, q, axis}, normal), expected);
    EXPECT_NEAR(gauge({axes_m, q, axis}, 0.7 * expected), 0.7, 1e-12);
  }
}

TEST(SuperExponents, TheNormalAtASupportPointIsThatOfItsPlane) {
  const Eigen::Vector3d axes_m(0.2, 0.3, 0.5);
  for (const int axis : {0, 1, 2})
    for (const SuperExponents q : {SuperExponents{1.3, 1.1, 1.8}, SuperExponents{2, 1.2, 1.5}}) {
      const Superellipsoid body{axes_m, q, axis};
      for (const double turn : {0.3, 1.4, 2.6, 4.0, 5.5}) {
        const Eigen::Vector3d n =
            Eigen::Vector3d(std::cos(turn), std::sin(turn), std::sin(2 * turn + 0.2)).normalized();
        EXPECT_LT((normal_at(body, support_point(body, n)) - n).norm(), 1e-9);
        EXPECT_LT((normal_at(body, 0.4 * support_point(body, n)) - n).norm(), 1e-9);
      }
    }
}

TEST(SuperExponents, DerivativesMatchDifferences) {
  constexpr double kStep = 1e-6;
  RandomStream random(6, "normals");
  for (int i = 0; i < 100; ++i) {
    const SuperExponents q{random.uniform(1.1, 1.9), random.uniform(1.1, 1.9), random.uniform(1.1, 1.9)};
    const Eigen::Vector3d n = random_normal(random);
    const auto d = superellipsoid_support_derivatives(kAxes, q, n, 1e-3);
    const auto slope = [&](const auto& h) { return (h(kStep) - h(-kStep)) / (2 * kStep); };
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d e = Eigen::Vector3d::Unit(k);
      EXPECT_NEAR(d.by_normal[k],
                  slope([&](double s) { return superellipsoid_support(kAxes, q, n + s * e, 1e-3); }), 1e-7);
      EXPECT_NEAR(d.by_log_axes[k], slope([&](double s) {
                    return superellipsoid_support(kAxes.cwiseProduct((s * e).array().exp().matrix()), q, n,
                                                  1e-3);
                  }),
                  1e-7);
    }
    EXPECT_NEAR(d.by_outline, slope([&](double s) {
                  return superellipsoid_support(kAxes, {q.outline + s, q.upper, q.lower}, n, 1e-3);
                }),
                1e-7);
    EXPECT_NEAR(d.by_profile, slope([&](double s) {
                  return superellipsoid_support(kAxes, {q.outline, q.upper + s, q.lower + s}, n, 1e-3);
                }),
                1e-7);
  }
}

}  // namespace
}  // namespace uniquadric
