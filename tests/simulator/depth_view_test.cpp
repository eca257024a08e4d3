#include "simulator/noise/depth_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "simulator/noise/depth_noise.h"
#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

constexpr double kNear_m = 1, kFar_m = 2;
const cv::Rect kBoard(200, 150, 240, 180);

// A board before a wall.
cv::Mat board_before_wall() {
  cv::Mat depth_m(480, 640, CV_32FC1, cv::Scalar(kFar_m));
  depth_m(kBoard).setTo(kNear_m);
  return depth_m;
}

DepthNoise exact_stereo() {
  DepthNoise noise;
  noise.model = DepthNoise::Model::stereo;
  noise.disparity_sigma_px = noise.disparity_step_px = 0;
  noise.edge_dropout = noise.flying_pixels = 0;
  noise.max_incidence_deg = 90;
  noise.shadow = false;
  return noise;
}

cv::Mat seen(const DepthNoise& noise, const cv::Mat& rgba = {}) {
  return add_depth_noise(board_before_wall(), rgba, {}, noise, 3, 8);
}

TEST(DepthView, RegisteredDepthHasTheShadowOfItsOwnCamera) {
  const Camera camera;
  for (const double offset_m : {0.04, -0.04}) {
    DepthNoise noise = exact_stereo();
    noise.color_offset_m = offset_m;
    const cv::Mat lost = seen(noise) == 0;
    // the parallax between board and wall; a camera on the right misses wall on the board's left
    const double wide_px = camera.fx * std::abs(offset_m) * (1 / kNear_m - 1 / kFar_m);
    EXPECT_NEAR(cv::countNonZero(lost.row(kBoard.y + 5)), wide_px, 1) << offset_m;
    const int beside = offset_m > 0 ? kBoard.x - 3 : kBoard.br().x + 2;
    EXPECT_TRUE(lost.at<std::uint8_t>(kBoard.y + 5, beside)) << offset_m;
    EXPECT_EQ(cv::countNonZero(lost.row(10)), 0) << offset_m;
  }
}

// A board whose rays have |x|, |y| < kBoardSide, before a wall, seen by a camera with lens distortion.
constexpr double kBoardSide = 0.3;
Camera distorted_camera() {
  Camera camera;
  camera.distortion = {-0.28, 0.07, 0.0012, -0.0008, 0.01};
  return camera;
}

cv::Mat distorted_board() {
  const PixelRays rays = distorted_camera();
  cv::Mat depth_m(rays.camera.height, rays.camera.width, CV_32FC1, cv::Scalar(kFar_m));
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u)
      if (rays.at(u, v).cwiseAbs().maxCoeff() < kBoardSide) depth_m.at<float>(v, u) = kNear_m;
  return depth_m;
}

TEST(DepthView, ShadowBehindALensIsThatOfTheRays) {
  const PixelRays rays = distorted_camera();
  constexpr double kRowBend = 5 / 525.0;  // a row of the image bends by 4 px along the board
  for (const double offset_m : {0.08, -0.08}) {
    DepthNoise noise = exact_stereo();
    noise.color_offset_m = offset_m;
    const cv::Mat lost = add_depth_noise(distorted_board(), {}, rays, noise, 3, 8) == 0;
    const double wide = std::abs(offset_m) * (1 / kNear_m - 1 / kFar_m);
    int compared = 0;
    for (int v = 0; v < lost.rows; ++v)
      for (int u = 0; u < lost.cols; ++u) {
        const Eigen::Vector2d ray = rays.at(u, v);
        const double beside = (offset_m > 0 ? -ray.x() : ray.x()) - kBoardSide;  // to the board's far side
        const double below_top = kBoardSide - std::abs(ray.y());
        const double inside = std::min({beside, wide - beside, below_top});
        if (std::min(std::abs(inside), std::abs(below_top)) < kRowBend) continue;
        ASSERT_EQ(lost.at<std::uint8_t>(v, u) != 0, inside > 0) << u << ", " << v;
        compared += inside > 0;
      }
    EXPECT_GT(compared, 1500);
  }
}

TEST(DepthView, UnregisteredDepthBehindALensStandsAtItsOwnRays) {
  const PixelRays rays = distorted_camera();
  DepthNoise noise = exact_stereo();
  noise.color_offset_m = 0.08;
  noise.registered = false;
  const cv::Mat moved = add_depth_noise(distorted_board(), {}, rays, noise, 3, 8);
  int near = 0;
  for (int v = 0; v < moved.rows; ++v)
    for (int u = 0; u < moved.cols; ++u) {
      if (!(moved.at<float>(v, u) > 0 && moved.at<float>(v, u) < 1.5)) continue;
      const Eigen::Vector2d ray = rays.at(u, v) + Eigen::Vector2d(0.08 / kNear_m, 0);
      ASSERT_LT(ray.cwiseAbs().maxCoeff(), kBoardSide + 1 / 525.0) << u << ", " << v;
      ++near;
    }
  EXPECT_GT(near, 0.9 * cv::countNonZero(distorted_board() < 1.5));
}

TEST(DepthView, UnregisteredDepthMovesByItsParallax) {
  const Camera camera;
  DepthNoise noise = exact_stereo();
  noise.color_offset_m = 0.04;
  noise.registered = false;
  const cv::Mat moved = seen(noise);
  const int shift = static_cast<int>(std::lround(camera.fx * 0.04 / kNear_m));
  const cv::Mat board = moved == kNear_m;
  EXPECT_EQ(cv::countNonZero(board), kBoard.area());
  EXPECT_EQ(cv::countNonZero(board(kBoard - cv::Point(shift, 0))), kBoard.area());
}

TEST(DepthView, RegistrationErrorMovesTheImage) {
  DepthNoise noise = exact_stereo();
  noise.registration_error_px = {3, -2};
  const cv::Mat moved = seen(noise), depth_m = board_before_wall();
  EXPECT_TRUE(same(moved(cv::Rect(3, 0, 637, 478)), depth_m(cv::Rect(0, 2, 637, 478))));
  EXPECT_EQ(cv::countNonZero(moved.col(0)), 0);
}

TEST(DepthView, SmearMixesDisparitiesWithinTheWindow) {
  DepthNoise noise = exact_stereo();
  noise.smear_px = 3;
  const cv::Mat mixed = seen(noise);
  const int v = kBoard.y + 90;
  const auto inverse = [&](int u) { return 1 / mixed.at<float>(v, u); };
  // the window's share of board pixels: k + 4 of 7 in the k-th column of the board
  for (int k = -3; k < 3; ++k) {
    const double share = (k + 4) / 7.0;
    EXPECT_NEAR(inverse(kBoard.x + k), share / kNear_m + (1 - share) / kFar_m, 1e-6) << k;
  }
  EXPECT_EQ(mixed.at<float>(v, kBoard.x - 6), static_cast<float>(kFar_m));
  EXPECT_EQ(mixed.at<float>(v, kBoard.x + 6), static_cast<float>(kNear_m));
}

TEST(DepthView, BiasOfDisparityGrowsWithTheSquareOfDepth) {
  DepthNoise noise = exact_stereo();
  noise.disparity_bias_px = 0.2;
  const cv::Mat biased = seen(noise);
  const double focal_baseline = Camera{}.fx * noise.baseline_m;
  for (const auto& [place, z_m] : {std::pair(cv::Point(10, 10), kFar_m), {cv::Point(300, 200), kNear_m}})
    EXPECT_NEAR(biased.at<float>(place), focal_baseline / (focal_baseline / z_m + 0.2), 1e-5);
}

TEST(DepthView, CorrelatedNoiseKeepsItsSigmaAndHasItsLength) {
  DepthNoise noise = exact_stereo();
  noise.disparity_sigma_px = 0.1;
  noise.correlation_px = 4;
  const cv::Mat depth_m(480, 640, CV_32FC1, cv::Scalar(kFar_m));
  const double focal_baseline = Camera{}.fx * noise.baseline_m;
  std::vector<double> errors, products;
  for (std::int64_t frame = 0; frame < 8; ++frame) {
    const cv::Mat noisy = add_depth_noise(depth_m, {}, {}, noise, 3, frame);
    const auto error = [&](int v, int u) {
      return (focal_baseline / noisy.at<float>(v, u) - focal_baseline / kFar_m) / 0.1;
    };
    for (int v = 2; v < 480; v += 16)  // beyond their length, errors are independent
      for (int u = 2; u + 4 < 640; u += 16) {
        errors.push_back(error(v, u));
        products.push_back(error(v, u) * error(v, u + 4));
      }
  }
  EXPECT_NEAR(deviation(errors), 1, kSigmas / std::sqrt(2 * count_of(errors)));
  EXPECT_NEAR(mean(products), std::exp(-0.5), kSigmas * deviation(products) / std::sqrt(count_of(products)));
}

TEST(DepthView, DarkAndFaintSurfacesLoseTheirShare) {
  DepthNoise noise = exact_stereo();
  noise.dark_dropout = 0.8;
  noise.dark_level = 40;
  cv::Mat rgba(480, 640, CV_8UC4, cv::Scalar(200, 200, 200, 255));
  rgba(cv::Rect(0, 0, 640, 120)).setTo(cv::Scalar(10, 10, 10, 255));      // a quarter of the level
  rgba(cv::Rect(0, 360, 640, 120)).setTo(cv::Scalar(200, 200, 200, 51));  // a fifth returns
  const cv::Mat lost = seen(noise, rgba) == 0;
  const double count = 640 * 120;
  const auto share = [&](int row) { return cv::countNonZero(lost(cv::Rect(0, row, 640, 120))) / count; };
  const double slack = kSigmas * 0.5 / std::sqrt(count);
  EXPECT_NEAR(share(0), 0.8 * 0.75, slack);
  EXPECT_EQ(share(200), 0);
  EXPECT_NEAR(share(360), 0.8, slack);
}

}  // namespace
}  // namespace uniquadric
