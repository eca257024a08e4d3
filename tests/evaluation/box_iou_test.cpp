#include "evaluation/iou/box_iou.h"

#include <gtest/gtest.h>

#include <random>

#include "core/geometry/pose.h"

namespace uniquadric {
namespace {

Ellipsoid box(const Eigen::Vector3d& half_m, const Eigen::Vector3d& centre_m = Eigen::Vector3d::Zero(),
              const Eigen::Vector3d& turn = Eigen::Vector3d::Zero()) {
  return {{exp_so3(turn), centre_m}, half_m};
}

constexpr double kExact = 1e-12;

TEST(BoxIou, OfTheSameBoxIsOne) {
  for (const double far_m : {0.0, 1e4}) {
    const Ellipsoid a = box({1, 2, 3}, Eigen::Vector3d::Constant(far_m), {0.3, -0.2, 0.5});
    EXPECT_DOUBLE_EQ(box_iou(a, a), 1);
  }
}

TEST(BoxIou, OfShiftedBoxesIsTheirCommonLength) {
  for (const double shift_m : {0.0, 0.25, 0.5, 1.5, 2.0, 2.5}) {
    const double common = std::max(0.0, 2 - shift_m);
    EXPECT_NEAR(box_iou(box({1, 2, 3}), box({1, 2, 3}, {shift_m, 0, 0})), common / (4 - common), kExact)
        << shift_m;
  }
}

TEST(BoxIou, OfABoxWithinAnotherIsTheRatioOfVolumes) {
  EXPECT_NEAR(box_iou(box({1, 1, 1}), box({0.5, 0.5, 0.25}, {0.1, 0.2, -0.3}, {1, 0.4, 0.2})), 0.0625,
              kExact);
  EXPECT_NEAR(box_iou(box({2, 1, 1}), box({1, 1, 1}, {1, 0, 0})), 0.5, kExact);  // three faces in one plane
}

// A square turned by 45 degrees within one of the same size: an octagon of area 8 (sqrt 2 - 1).
TEST(BoxIou, OfATurnedSquareIsTheOctagons) {
  const double octagon = 8 * (std::sqrt(2.0) - 1);
  EXPECT_NEAR(box_iou(box({1, 1, 3}), box({1, 1, 3}, {0, 0, 0}, {0, 0, M_PI / 4})), octagon / (8 - octagon),
              kExact);
  EXPECT_NEAR(box_iou(box({1, 1, 0.01}), box({1, 1, 0.01}, {0, 0, 0}, {0, 0, M_PI / 4})),
              octagon / (8 - octagon),
              kExact);  // thin
}

TEST(BoxIou, OfBoxesThatTouchOrLieApartIsZero) {
  EXPECT_NEAR(box_iou(box({1, 1, 1}), box({1, 1, 1}, {2, 0, 0})), 0, kExact);
  EXPECT_NEAR(box_iou(box({1, 1, 1}), box({1, 1, 1}, {1 + std::sqrt(2.0), 0, 0}, {0, 0, M_PI / 4})), 0,
              kExact);
  EXPECT_EQ(box_iou(box({1, 1, 1}), box({1, 1, 1}, {5, 5, 5}, {0.1, 0.2, 0.3})), 0);
}

// Face to face, however both are turned: no volume, and none by rounding.
TEST(BoxIou, OfTurnedBoxesThatShareAFaceIsZero) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> within(-3, 3);
  for (int trial = 0; trial < 2000; ++trial) {
    const Eigen::Vector3d turn(within(random), within(random), within(random));
    const Eigen::Vector3d shift = exp_so3(turn) * Eigen::Vector3d(0.4, 0, 0);
    const Ellipsoid a = box({0.2, 0.2, 0.2}, {1, 2, 3}, turn),
                    b = box({0.2, 0.2, 0.2}, Eigen::Vector3d(1, 2, 3) + shift, turn);
    EXPECT_LT(box_iou(a, b), 1e-12);
    EXPECT_LT(box_iou(b, a), 1e-12);
  }
}

// The same box but for a turn of rounding size, and of any size between: 1 less what the turn takes.
TEST(BoxIou, OfHardlyTurnedBoxesIsNearlyOne) {
  for (double angle = 1e-16; angle < 1e-2; angle *= 3)
    for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0.6, 0, 0.8)}) {
      const Ellipsoid a = box({1, 2, 3}, {0.1, 0, 0}, {0.3, 0.2, 0.1}),
                      b = box({1, 2, 3}, {0.1, 0, 0}, Eigen::Vector3d(0.3, 0.2, 0.1) + angle * axis);
      EXPECT_GT(box_iou(a, b), 1 - 4 * angle - kExact) << angle;
      EXPECT_NEAR(box_iou(a, b), box_iou(b, a), kExact) << angle;
    }
}

// A second way: the share of random points of one that lie in the other.
TEST(BoxIou, AgreesWithCountedPoints) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> within(-1, 1);
  const auto vector = [&] { return Eigen::Vector3d(within(random), within(random), within(random)); };
  for (int trial = 0; trial < 20; ++trial) {
    const Ellipsoid a = box(vector().cwiseAbs().array() + 0.2, vector(), vector());
    const Ellipsoid b = box(vector().cwiseAbs().array() + 0.2, 0.7 * vector(), 2 * vector());
    constexpr int kPoints = 200'000;
    int inside = 0;
    const Pose b_from_a = b.world_from_object.inverse() * a.world_from_object;
    for (int i = 0; i < kPoints; ++i)
      inside += ((b_from_a * a.semi_axes_m.cwiseProduct(vector()).eval()).cwiseAbs().array() <=
                 b.semi_axes_m.array())
                    .all();
    const double share = inside / double(kPoints), common = share * 8 * a.semi_axes_m.prod();
    const double sum = 8 * (a.semi_axes_m.prod() + b.semi_axes_m.prod());
    const double stderr_ = std::sqrt(share * (1 - share) / kPoints) * 8 * a.semi_axes_m.prod();
    const double iou = box_iou(a, b), volume = iou / (1 + iou) * sum;
    EXPECT_NEAR(volume, common, 4 * stderr_ + 1e-9) << trial;
    EXPECT_NEAR(box_iou(b, a), iou, kExact);
  }
}

// Moved as a whole, 10 km away.
TEST(BoxIou, DoesNotDependOnThePlace) {
  const Ellipsoid a = box({1, 0.01, 0.5}, {0, 0, 0}, {0.2, 0.1, 0}),
                  b = box({0.9, 0.012, 0.5}, {0.1, 0.001, 0}, {0.2, 0.11, 0});
  const Pose far{exp_so3({1, 2, -0.5}), {1e4, -2e3, 500}};
  const auto moved = [&](Ellipsoid e) {
    e.world_from_object = far * e.world_from_object;
    return e;
  };
  EXPECT_NEAR(box_iou(moved(a), moved(b)), box_iou(a, b), 1e-6);
  EXPECT_GT(box_iou(a, b), 0.1);
}

}  // namespace
}  // namespace uniquadric
