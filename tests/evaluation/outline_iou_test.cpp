#include <gtest/gtest.h>

#include <numbers>

#include "core/base/random.h"
#include "evaluation/iou/outline_iou.h"

namespace uniquadric {
namespace {
using std::numbers::pi;
constexpr double kClipper = 1e-8;  // rounding to 2^30 across the joint extent

Ellipse ellipse(double x, double y, double major, double minor, double angle) {
  return {{x, y}, major, minor, angle};
}

// Points of a regular grid in both shapes over those in either.
template <typename Inside>
double grid_iou(const Ellipse& a, const Ellipse& b, int n, const Inside& inside) {
  const double reach = std::max(a.semi_major, b.semi_major) * 1.5 + (a.center - b.center).norm();
  int both = 0, either = 0;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) {
      const Eigen::Vector2d p =
          a.center + reach * Eigen::Vector2d(2 * (i + 0.5) / n - 1, 2 * (j + 0.5) / n - 1);
      const bool in_a = inside(a, p), in_b = inside(b, p);
      both += in_a && in_b;
      either += in_a || in_b;
    }
  return static_cast<double>(both) / either;
}

Eigen::Vector2d local(const Ellipse& e, const Eigen::Vector2d& p) {
  return (Eigen::Rotation2Dd(-e.angle_rad) * (p - e.center))
      .cwiseQuotient(Eigen::Vector2d(e.semi_major, e.semi_minor));
}
}  // namespace

TEST(OutlineIou, IdenticalIsOneAndDisjointIsZero) {
  const Ellipse e = ellipse(311.25, 77.5, 40.125, 13.75, 0.7), far = ellipse(900, 77.5, 40, 13, 0.7);
  for (const auto& iou : {ellipse_iou, rotated_rectangle_iou, axis_aligned_box_iou}) {
    EXPECT_EQ(iou(e, e), 1);
    EXPECT_EQ(iou(e, far), 0);
  }
}

TEST(OutlineIou, ClosedForms) {
  // a square turned by 45 degrees inside its equal: a regular octagon of area 8 (sqrt 2 - 1) a^2
  const double octagon = 8 * (std::sqrt(2) - 1);
  EXPECT_NEAR(rotated_rectangle_iou(ellipse(5, 5, 1, 1, 0), ellipse(5, 5, 1, 1, pi / 4)),
              octagon / (8 - octagon), kClipper);
  EXPECT_NEAR(rotated_rectangle_iou(ellipse(0, 0, 2, 1, 0), ellipse(2, 0, 2, 1, 0)), 1.0 / 3, kClipper);
  EXPECT_NEAR(axis_aligned_box_iou(ellipse(0, 0, 2, 1, 0), ellipse(2, 0, 2, 1, 0)), 1.0 / 3, 1e-15);
  // two unit discs at distance 1
  const double lens = 2 * pi / 3 - std::sqrt(3) / 2;
  EXPECT_NEAR(ellipse_iou(ellipse(0, 0, 1, 1, 0), ellipse(0, 1, 1, 1, 0)), lens / (2 * pi - lens), 1e-14);
  // one ellipse crossed with itself: 4 a b atan(b / a) in common
  const double common = 4 * 3 * std::atan(1.0 / 3);
  EXPECT_NEAR(ellipse_iou(ellipse(0, 0, 3, 1, 0.2), ellipse(0, 0, 3, 1, 0.2 + pi / 2)),
              common / (6 * pi - common), 1e-13);
}

TEST(OutlineIou, RandomPairsAgreeWithCounting) {
  RandomStream random(1, "outlines");
  constexpr int kGrid = 350;
  constexpr double kCounting = 1e-2;  // cells along the outlines
  for (int i = 0; i < 8; ++i) {
    const auto draw = [&] {
      const double minor = random.uniform(5, 30);
      return ellipse(300 + random.uniform(-20, 20), 200 + random.uniform(-20, 20),
                     minor * random.uniform(1, 4), minor, random.uniform(0, pi));
    };
    const Ellipse a = draw(), b = draw();
    EXPECT_NEAR(ellipse_iou(a, b),
                grid_iou(a, b, kGrid,
                         [](const Ellipse& e, const Eigen::Vector2d& p) { return local(e, p).norm() < 1; }),
                kCounting);
    EXPECT_NEAR(rotated_rectangle_iou(a, b),
                grid_iou(a, b, kGrid,
                         [](const Ellipse& e, const Eigen::Vector2d& p) {
                           return local(e, p).cwiseAbs().maxCoeff() < 1;
                         }),
                kCounting);
    EXPECT_EQ(ellipse_iou(a, b), ellipse_iou(b, a));
    EXPECT_EQ(rotated_rectangle_iou(a, b), rotated_rectangle_iou(b, a));
  }
}

TEST(OutlineIou, ClippedToTheImage) {
  Camera camera;
  camera.width = 100;
  camera.height = 80;
  // The image begins at -0.5: the first rectangle keeps [-0.5, 10] of [-10, 10], the second [-0.5, 20] of [0
  // - 20, 20].
  const Ellipse a = ellipse(0, 40, 10, 5, 0), b = ellipse(0, 40, 20, 5, 0);
  EXPECT_NEAR(*clipped_rectangle_iou(a, b, camera), 10.5 / 20.5, kClipper);
  EXPECT_EQ(clipped_rectangle_iou(a, ellipse(300, 40, 10, 5, 0), camera), 0);
  EXPECT_EQ(clipped_rectangle_iou(ellipse(-50, 40, 10, 5, 0), ellipse(300, 40, 10, 5, 0), camera),
            std::nullopt);
}

TEST(OutlineIou, RectanglesJumpForNearCirclesOutlinesDoNot) {
  const Ellipse a = ellipse(0, 0, 1.0001, 1, 0), b = ellipse(0, 0, 1.0001, 1, pi / 4);
  EXPECT_NEAR(rotated_rectangle_iou(a, b), 0.707, 1e-3);
  EXPECT_GT(ellipse_iou(a, b), 0.9998);
}

}  // namespace uniquadric
