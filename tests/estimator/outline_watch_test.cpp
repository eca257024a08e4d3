#include "estimator/objects/outline_watch.h"

#include <gtest/gtest.h>

#include <numbers>

namespace uniquadric {
namespace {

constexpr std::int64_t kFrame_ns = 33'000'000;
const Camera kCamera{640, 480, 500, 500, 320, 240};

// The rectangle's tangents: half widths in metres at a distance, about the image's centre.
Silhouette outline_of(double half_x_m, double half_y_m, double distance_m) {
  Silhouette outline;
  for (int k = 0; k < 16; ++k) {
    const double angle = 2 * std::numbers::pi * k / 16;
    SupportLine line;
    line.normal = {std::cos(angle), std::sin(angle)};
    const double reach_m = std::abs(line.normal.x()) * half_x_m + std::abs(line.normal.y()) * half_y_m;
    line.offset_px = line.normal.dot(Eigen::Vector2d(kCamera.cx, kCamera.cy)) + 500 * reach_m / distance_m;
    outline.support.push_back(line);
  }
  return outline;
}

Pose at(double distance_m, double turned_rad = 0) {
  return {exp_so3({0, turned_rad, 0}), {0, 0, distance_m}};
}

class OutlineOfABox : public testing::Test {
 protected:
  OutlineOfABox() { watch_.trust(kCamera, outline_of(0.1, 0.2, 2), 0, at(2), kCenter); }

  bool may_be(const Silhouette& outline, const Pose& pose, std::int64_t stamp_ns = kFrame_ns) const {
    return watch_.may_be(kCamera, outline, stamp_ns, pose, kCenter);
  }

  const Eigen::Vector3d kCenter = Eigen::Vector3d::Zero();
  OutlineWatch watch_;
};

TEST_F(OutlineOfABox, GrowsAsItComesNearer) {
  EXPECT_TRUE(may_be(outline_of(0.1, 0.2, 1), at(1)));
  EXPECT_FALSE(may_be(outline_of(0.1, 0.2, 1), at(2)));
}

TEST_F(OutlineOfABox, IsNotSuddenlyTwiceAsWideNorHalfAsHigh) {
  EXPECT_TRUE(may_be(outline_of(0.11, 0.21, 2), at(2)));
  EXPECT_FALSE(may_be(outline_of(0.2, 0.2, 2), at(2)));
  EXPECT_FALSE(may_be(outline_of(0.1, 0.1, 2), at(2)));
}

// By no more than its diameter a radian: .2 m wide and .44 m in diameter, it may well be .4 m after .5 rad.
TEST_F(OutlineOfABox, UnlessItTurns) {
  EXPECT_TRUE(may_be(outline_of(0.2, 0.2, 2), at(2, 0.5)));
  EXPECT_FALSE(may_be(outline_of(0.4, 0.2, 2), at(2, 0.5)));
}

TEST_F(OutlineOfABox, SaysNothingWhereItIsCut) {
  Silhouette cut = outline_of(0.1, 0.05, 2);
  for (SupportLine& line : cut.support) line.free = line.normal.y() < 0.1;
  EXPECT_TRUE(may_be(cut, at(2)));
}

TEST_F(OutlineOfABox, NorAfterASecond) {
  EXPECT_TRUE(may_be(outline_of(0.2, 0.2, 2), at(2), 40 * kFrame_ns));
}

}  // namespace
}  // namespace uniquadric
