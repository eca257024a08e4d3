#include "estimator/features/patch_alignment.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>

#include "core/base/random.h"
#include "drawn_world.h"
#include "estimator/features/corners.h"

namespace uniquadric {
namespace {

// A textured card, its own frame being the map.
struct CardView {
  std::vector<DrawnCard> card{{0, {2.4, 1.8}, block_texture(700, 3), {}}};
  DrawnFrame from(const Pose& camera_from_card, const DrawnNoise& noise, int frame) const {
    return draw(small_camera(), moved(card, camera_from_card), noise, frame);
  }
};

const Pose kFront{exp_so3({0.05, 0.1, 0.02}), {0, 0, 1.6}};
const Pose kSide{exp_so3({0.1, 0.6, 0.25}), {0.05, -0.03, 1.5}};  // turned by half a radian
const Eigen::Vector3d kTowardsCamera(0, 0, -1);

// Where the ray through a pixel meets the card.
Eigen::Vector3d on_card(const Pose& camera_from_card, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3d ray = camera_from_card.rotation.conjugate() * *small_camera().unproject(pixel);
  const Eigen::Vector3d origin = camera_from_card.inverse().translation;
  return origin - origin.z() / ray.z() * ray;
}

TEST(PatchAlignment, TheWarpIsTheHomographysDerivative) {
  const Eigen::Vector2d pixel(140, 100);
  const PatchAnchor anchor{cv::Mat(33, 33, CV_8UC1, cv::Scalar(0)), {16, 16}, pixel, kFront};
  const auto warp = anchor_warp(anchor, {on_card(kFront, pixel), kTowardsCamera}, small_camera(), kSide);
  ASSERT_TRUE(warp);
  const auto carried = [](const Eigen::Vector2d& p) {
    return *small_camera().project(kSide * on_card(kFront, p));
  };
  constexpr double kStep = 1e-3, kCurvature = 2e-3;  // the warp is a difference over some pixels
  for (int k = 0; k < 2; ++k) {
    const Eigen::Vector2d step = kStep * Eigen::Vector2d::Unit(k);
    EXPECT_LT(((carried(pixel + step) - carried(pixel - step)) / (2 * kStep) - warp->col(k)).norm(),
              kCurvature);
  }
  EXPECT_FALSE(anchor_warp(anchor, {on_card(kFront, pixel), -kTowardsCamera}, small_camera(), kSide));
  const Pose edge_on{exp_so3({0, 1.5, 0}), {0, 0, 1.5}};
  EXPECT_FALSE(anchor_warp(anchor, {on_card(kFront, pixel), kTowardsCamera}, small_camera(), edge_on));
}

TEST(PatchAlignment, FindsTheSamePointFromAnotherSide) {
  const CardView card;
  const DrawnNoise noise{0, 2};
  const auto front = card.from(kFront, noise, 0), side = card.from(kSide, noise, 1);
  RandomStream random(1, "test");
  double squares = 0, told = 0;
  int found = 0, tried = 0;
  for (const auto& corner : fast_corners(front.gray, 25)) {
    const Eigen::Vector3d point = on_card(kFront, corner.pixel);
    const auto truth = small_camera().project(kSide * point);
    const auto anchor = make_anchor(front.gray, corner.pixel, kFront);
    const cv::Rect2d inside(12, 12, 296, 216);
    if (!anchor || !truth || !inside.contains(cv::Point2d(truth->x(), truth->y()))) continue;
    const auto warp = anchor_warp(*anchor, {point, kTowardsCamera}, small_camera(), kSide);
    ASSERT_TRUE(warp);
    ++tried;
    const Eigen::Vector2d start =
        *truth + Eigen::Vector2d(random.uniform(-0.8, 0.8), random.uniform(-0.8, 0.8));
    const auto aligned = align_patch(*anchor, *warp, side.gray, start, {});
    if (!aligned) continue;
    ++found;
    squares += (aligned->pixel - *truth).squaredNorm();
    told += 2 * aligned->sigma_px * aligned->sigma_px;
  }
  ASSERT_GT(tried, 60);
  EXPECT_GT(found, 0.8 * tried);
  EXPECT_LT(std::sqrt(squares / found), 0.15);
  EXPECT_LT(squares, 4 * told);  // the sigma is of the worse direction: it covers the error
}

TEST(PatchAlignment, FindsNothingElsewhere) {
  const CardView card;
  const auto front = card.from(kFront, {}, 0);
  const auto corners = fast_corners(front.gray, 40);
  int tried = 0, found = 0;
  for (std::size_t i = 0; i + 7 < corners.size(); ++i) {
    const auto anchor = make_anchor(front.gray, corners[i].pixel, kFront);
    if (!anchor || (corners[i].pixel - corners[i + 7].pixel).norm() < 10) continue;
    ++tried;
    found +=
        align_patch(*anchor, Eigen::Matrix2d::Identity(), front.gray, corners[i + 7].pixel, {}).has_value();
  }
  ASSERT_GT(tried, 30);
  EXPECT_LT(found, 0.2 * tried);  // corners of blocks are like other corners of blocks
  EXPECT_FALSE(make_anchor(front.gray, {3, 100}, kFront));
  const cv::Mat flat(240, 320, CV_8UC1, cv::Scalar(90));
  const auto blank = make_anchor(flat, {100, 100}, kFront);
  ASSERT_TRUE(blank);
  EXPECT_FALSE(align_patch(*blank, Eigen::Matrix2d::Identity(), flat, {100, 100}, {}));
}

}  // namespace
}  // namespace uniquadric
