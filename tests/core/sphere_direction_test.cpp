#include "core/geometry/sphere_direction.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace uniquadric {
namespace {

TEST(SphereDirection, LiesEvenlyOverTheSphere) {
  const int count = 500;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d moment = Eigen::Matrix3d::Zero();
  double nearest = std::numeric_limits<double>::max();
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d a = sphere_direction(i, count);
    EXPECT_NEAR(a.norm(), 1, 1e-12);
    mean += a / count;
    moment += a * a.transpose() / count;
    for (int k = 0; k < i; ++k) nearest = std::min(nearest, (a - sphere_direction(k, count)).norm());
  }
  EXPECT_LT(mean.norm(), 1e-3);
  EXPECT_LT((moment - Eigen::Matrix3d::Identity() / 3).norm(), 1e-3);
  EXPECT_GT(nearest, 0.8 * std::sqrt(4 * std::numbers::pi / count));  // of the side of a square of its share
}

}  // namespace
}  // namespace uniquadric
