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

}  // namespace
}  // namespace uniquadric
