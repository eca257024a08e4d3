// Silhouettes of shapes drawn pixel by pixel, whose tangents are known in closed form.
#include "estimator/observation/silhouette.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {

const Camera kCamera{320, 240, 260, 260, 159.5, 119.5, {}};
constexpr double kPi = std::numbers::pi;
using Inside = std::function<bool(const Eigen::Vector2d&)>;

void draw(cv::Mat& masks, int id, const Inside& inside) {
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u)
      if (inside({u, v})) masks.at<std::uint16_t>(v, u) = static_cast<std::uint16_t>(id);
}

cv::Mat empty_masks() {
  return cv::Mat::zeros(kCamera.height, kCamera.width, CV_16UC1);
}

Inside disc(const Eigen::Vector2d& center, double radius) {
  return [=](const Eigen::Vector2d& p) { return (p - center).norm() <= radius; };
}

Inside rectangle(const Eigen::Vector2d& center, double half_x, double half_y, double angle_rad) {
  const Eigen::Vector2d x(std::cos(angle_rad), std::sin(angle_rad)), y(-x.y(), x.x());
  return [=](const Eigen::Vector2d& p) {
    return std::abs(x.dot(p - center)) <= half_x && std::abs(y.dot(p - center)) <= half_y;
  };
}

Inside half_plane_left_of(double u) {
  return [=](const Eigen::Vector2d& p) { return p.x() <= u; };
}

cv::Mat depth_of(const cv::Mat& masks, const std::map<int, float>& depth_m) {
  cv::Mat depth(masks.size(), CV_32FC1);
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) depth.at<float>(v, u) = depth_m.at(masks.at<std::uint16_t>(v, u));
  return depth;
}

Silhouette only(const cv::Mat& masks, const cv::Mat& depth = {}, const SilhouetteOptions& options = {}) {
  const auto found = silhouettes(masks, depth, kCamera, options);
  EXPECT_EQ(found.size(), 1u);
  return found.empty() ? Silhouette{} : found.begin()->second;
}

// Distance between two directions of a rectangle, which are equal after a quarter or half turn.
double angle_between(double a, double b, double period) {
  return std::abs(std::remainder(a - b, period));
}

TEST(Silhouette, ADiscIsTouchedAtItsRadiusInEveryDirection) {
  int lines = 0;
  for (const double shift : {0.0, 0.3, 0.5, 0.77}) {
    const Eigen::Vector2d center(150 + shift, 120 - shift);
    cv::Mat masks = empty_masks();
    draw(masks, 5, disc(center, 41.4));
    const Silhouette silhouette = only(masks);
    ASSERT_EQ(silhouette.support.size(), 16u);
    for (int k = 0; k < 16; ++k) {
      const SupportLine& line = silhouette.support[k];
      EXPECT_NEAR(std::atan2(line.normal.y(), line.normal.x()), std::remainder(k * kPi / 8, 2 * kPi), 1e-12);
      EXPECT_NEAR(line.offset_px, line.normal.dot(center) + 41.4, 0.6) << k;
      EXPECT_TRUE(line.free);
      ++lines;
    }
    EXPECT_NEAR(silhouette.rot_bbox.semi_major, 41.4, 0.6);
    EXPECT_NEAR(silhouette.rot_bbox.semi_minor, 41.4, 0.6);
    EXPECT_NEAR((silhouette.rot_bbox.center - center).norm(), 0, 0.45);
    EXPECT_NEAR(silhouette.area_px, kPi * 41.4 * 41.4, 15);
  }
  EXPECT_EQ(lines, 64);
}

TEST(Silhouette, ATurnedRectangleIsItsOwnRotBbox) {
  int cases = 0;
  for (int i = 0; i < 12; ++i) {
    const double angle = 0.04 + i * kPi / 12;
    const Eigen::Vector2d center(160 + 0.37 * i, 118 - 0.21 * i);
    cv::Mat masks = empty_masks();
    draw(masks, 1, rectangle(center, 60.3, 25.6, angle));
    const Silhouette silhouette = only(masks);
    EXPECT_NEAR(silhouette.rot_bbox.semi_major, 60.3, 0.6) << angle;
    EXPECT_NEAR(silhouette.rot_bbox.semi_minor, 25.6, 0.6) << angle;
    EXPECT_NEAR((silhouette.rot_bbox.center - center).norm(), 0, 0.5) << angle;
    EXPECT_LT(angle_between(silhouette.rot_bbox.angle_rad, angle, kPi), 0.02) << angle;
    EXPECT_GE(silhouette.rot_bbox.angle_rad, 0);
    EXPECT_LT(silhouette.rot_bbox.angle_rad, kPi);
    for (const SupportLine& line : silhouette.support) {
      const Eigen::Vector2d x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
      const double offset =
          line.normal.dot(center) + 60.3 * std::abs(line.normal.dot(x)) + 25.6 * std::abs(line.normal.dot(y));
      EXPECT_NEAR(line.offset_px, offset, 1.1) << angle;
    }
    ++cases;
  }
  EXPECT_EQ(cases, 12);
}

// An upright rectangle of whole pixels: its outline runs half a pixel outside its outer pixel centres.
TEST(Silhouette, PixelsReachHalfAPixelBeyondTheirCentres) {
  cv::Mat masks = empty_masks();
  masks(cv::Rect(100, 60, 40, 20)).setTo(3);  // centres 100..139, 60..79
  const Silhouette silhouette = only(masks);
  EXPECT_NEAR(silhouette.bbox[0].offset_px, 139.5, 1e-9);
  EXPECT_NEAR(silhouette.bbox[1].offset_px, 79.5, 1e-9);
  EXPECT_NEAR(silhouette.bbox[2].offset_px, -99.5, 1e-9);
  EXPECT_NEAR(silhouette.bbox[3].offset_px, -59.5, 1e-9);
  EXPECT_NEAR(silhouette.rot_bbox.semi_major, 20, 1e-9);
  EXPECT_NEAR(silhouette.rot_bbox.semi_minor, 10, 1e-9);
  EXPECT_EQ(silhouette.area_px, 800);
}

TEST(Silhouette, TheImagesBorderIsNoTangent) {
  cv::Mat masks = empty_masks();
  draw(masks, 1, rectangle({10, 100}, 40, 25, 0));  // runs out of the image to the left
  const Silhouette silhouette = only(masks);
  EXPECT_TRUE(silhouette.bbox[0].free);
  EXPECT_TRUE(silhouette.bbox[1].free);
  EXPECT_FALSE(silhouette.bbox[2].free);
  EXPECT_TRUE(silhouette.bbox[3].free);
  int cut = 0;
  for (const SupportLine& line : silhouette.support) {
    EXPECT_EQ(line.free, line.normal.x() > -1e-9) << line.normal.transpose();  // all to the left touch it
    cut += !line.free;
  }
  EXPECT_EQ(cut, 7);
  const bool turned = angle_between(silhouette.rot_bbox.angle_rad, kPi / 2, kPi) < 0.1;
  ASSERT_TRUE(turned || angle_between(silhouette.rot_bbox.angle_rad, 0, kPi) < 0.1);
  EXPECT_EQ(
      silhouette.side_free[0] + silhouette.side_free[1] + silhouette.side_free[2] + silhouette.side_free[3],
      3);
}

// Sides in the order +major, -major, +minor, -minor.
TEST(Silhouette, SidesOfTheRotBboxAreMarkedAtTheirPlaces) {
  int cases = 0;
  for (const double angle : {0.3, 2.0}) {
    const Eigen::Vector2d center(160, 120), x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
    for (int side = 0; side < 4; ++side) {
      const Eigen::Vector2d outward = (side % 2 ? -1 : 1) * (side < 2 ? x : y);
      cv::Mat masks = empty_masks();
      draw(masks, 1, rectangle(center, 50, 25, angle));
      draw(masks, 2,
           [&](const Eigen::Vector2d& p) { return outward.dot(p - center) > (side < 2 ? 40 : 18); });
      const auto found = silhouettes(masks, depth_of(masks, {{0, 3}, {1, 2}, {2, 1}}), kCamera, {});
      ASSERT_TRUE(found.contains(1));
      const Silhouette& body = found.at(1);
      ASSERT_LT(angle_between(body.rot_bbox.angle_rad, angle, kPi), 0.03);
      const double flip = std::cos(body.rot_bbox.angle_rad - angle);
      for (int i = 0; i < 4; ++i)
        EXPECT_EQ(body.side_free[i], i != (flip > 0 ? side : side ^ 1)) << side << i;
      ++cases;
    }
  }
  EXPECT_EQ(cases, 8);
}

// A body that a nearer one hides in part is cut there; the nearer one is not.
TEST(Silhouette, ANearerBodyCutsAndAFartherDoesNot) {
  cv::Mat masks = empty_masks();
  draw(masks, 1, disc({150, 120}, 50));
  draw(masks, 2, half_plane_left_of(120));
  const cv::Mat depth = depth_of(masks, {{0, 4}, {1, 2}, {2, 1}});
  const auto found = silhouettes(masks, depth, kCamera, {});
  EXPECT_FALSE(found.at(1).bbox[2].free);
  EXPECT_TRUE(found.at(1).bbox[0].free);
  EXPECT_TRUE(found.at(1).bbox[1].free);
  EXPECT_TRUE(found.at(2).bbox[0].free);
  EXPECT_FALSE(found.at(2).bbox[2].free);                  // at the border
  const auto blind = silhouettes(masks, {}, kCamera, {});  // without depth neither is known to be in front
  EXPECT_FALSE(blind.at(1).bbox[2].free);
  EXPECT_FALSE(blind.at(2).bbox[0].free);
  EXPECT_TRUE(blind.at(1).bbox[0].free);
}

// Where the nearer one's edge crosses the outline, the body goes on behind it: what is called free is the
// tangent of all of it. So it is where masks are off by some pixels.
TEST(Silhouette, NoTangentIsWhereANearerEdgeCrossesTheOutline) {
  const Eigen::Vector2d center(150, 120);
  for (const double angle : {-0.6, -0.25, 0.25, 0.6})
    for (const auto& [edge_px, off_px] : {std::pair(115.0, 0),
                                          {130.0, 0},
                                          {150.0, 0},
                                          {170.0, 0},
                                          {130.0, 2},
                                          {150.0, 2},
                                          {130.0, -2},
                                          {150.0, -2}}) {
      cv::Mat exact = empty_masks(), masks = empty_masks();
      draw(exact, 1, rectangle(center, 50, 30, angle));
      draw(exact, 2, half_plane_left_of(edge_px));
      draw(masks, 1, rectangle(center, 50, 30, angle));
      draw(masks, 2, half_plane_left_of(edge_px - off_px));
      const auto found = silhouettes(masks, depth_of(exact, {{0, 4}, {1, 2}, {2, 1}}), kCamera, {});
      int free = 0;
      for (const SupportLine& line : found.at(1).support) {
        if (!line.free) continue;
        ++free;
        const Eigen::Vector2d n = Eigen::Rotation2Dd(-angle) * line.normal;
        const double expected = line.normal.dot(center) + 50 * std::abs(n.x()) + 30 * std::abs(n.y());
        EXPECT_NEAR(line.offset_px, expected, 2)
            << angle << ' ' << edge_px << ' ' << off_px << ' ' << line.normal.transpose();
      }
      EXPECT_GE(free, 5) << angle << ' ' << edge_px << ' ' << off_px;
    }
}

// One nearer pixel beside the outline, a wrong measurement, cuts nothing; and beside a body, what is nearer
// by less than depth may err is no other in front.
TEST(Silhouette, NoiseBesideTheOutlineCutsNothing) {
  cv::Mat masks = empty_masks();
  draw(masks, 1, rectangle({150, 120}, 50, 30, std::numbers::pi / 4));
  draw(masks, 2, rectangle({150, 205}, 80, 30, 0));
  cv::Mat depth = depth_of(masks, {{0, 4}, {1, 2}, {2, 1.995}});
  depth.at<float>(134, 209) = 1;  // beside the corner on the right
  const auto found = silhouettes(masks, depth, kCamera, {});
  for (const SupportLine& side : found.at(1).bbox) EXPECT_TRUE(side.free) << side.normal.transpose();
}

// On the ground a body's sides stay tangents: of what has no id, nearer ground beside its foot is no edge in
// front of it.
TEST(Silhouette, GroundBesideTheFootCutsNoSide) {
  cv::Mat masks = empty_masks();
  draw(masks, 1, rectangle({150, 120}, 50, 30, -0.6));  // rightmost is a corner at 116
  cv::Mat depth = depth_of(masks, {{0, 4}, {1, 2}});
  for (int v = 119; v < 139; ++v)
    for (int u = 0; u < depth.cols; ++u)
      if (masks.at<std::uint16_t>(v, u) == 0)
        depth.at<float>(v, u) = 2.0F - 0.05F * static_cast<float>(v - 118);
  EXPECT_TRUE(silhouettes(masks, depth, kCamera, {}).at(1).bbox[0].free);
}

// What hides the body need not have an id: a shelf seen by its depth alone.
TEST(Silhouette, ANearerSurfaceWithoutAnIdCuts) {
  cv::Mat masks = empty_masks(), kinds = empty_masks();
  draw(kinds, 1, disc({150, 120}, 50));
  draw(kinds, 2, half_plane_left_of(120));
  draw(masks, 1, disc({150, 120}, 50));
  masks.setTo(0, kinds == 2);
  const Silhouette near_shelf = only(masks, depth_of(kinds, {{0, 4}, {1, 2}, {2, 1.7F}}));
  EXPECT_FALSE(near_shelf.bbox[2].free);
  EXPECT_TRUE(near_shelf.bbox[0].free);
  const Silhouette far_wall = only(masks, depth_of(kinds, {{0, 4}, {1, 2}, {2, 2.1F}}));
  EXPECT_TRUE(far_wall.bbox[2].free);
}

TEST(Silhouette, ABodySeenThroughAHoleHasNoTangent) {
  cv::Mat masks = empty_masks();
  masks.setTo(2);
  draw(masks, 1, disc({160, 120}, 30));
  const auto found = silhouettes(masks, depth_of(masks, {{1, 3}, {2, 1}}), kCamera, {});
  int cut = 0;
  for (const SupportLine& line : found.at(1).support) cut += !line.free;
  EXPECT_EQ(cut, 16);
}

TEST(Silhouette, APartBehindAPoleCountsAndSpecksDoNot) {
  cv::Mat masks = empty_masks();
  masks(cv::Rect(100, 80, 60, 40)).setTo(1);
  masks(cv::Rect(125, 80, 6, 40)).setTo(0);  // the pole
  masks(cv::Rect(10, 10, 9, 9)).setTo(1);    // a speck of 81 pixels, beside parts of 1000 and 1160
  const Silhouette silhouette = only(masks);
  EXPECT_NEAR(silhouette.bbox[0].offset_px, 159.5, 1e-9);
  EXPECT_NEAR(silhouette.bbox[2].offset_px, -99.5, 1e-9);
  EXPECT_NEAR(silhouette.bbox[3].offset_px, -79.5, 1e-9);
  EXPECT_EQ(silhouette.area_px, 2160);
}

TEST(Silhouette, TheLensIsUndone) {
  Camera camera = kCamera;
  camera.distortion = {-0.25, 0.08, 0.001, -0.0005, 0};
  const Eigen::Vector2d center(60, 60);
  cv::Mat masks = empty_masks();
  draw(masks, 1, [&](const Eigen::Vector2d& p) {
    const auto ray = camera.unproject(p);
    return ray && disc(center, 35)({camera.fx * ray->x() + camera.cx, camera.fy * ray->y() + camera.cy});
  });
  const auto found = silhouettes(masks, {}, camera, {});
  ASSERT_EQ(found.size(), 1u);
  for (const SupportLine& line : found.at(1).support)
    EXPECT_NEAR(line.offset_px, line.normal.dot(center) + 35, 0.7) << line.normal.transpose();
}

TEST(Silhouette, NothingAndNextToNothing) {
  cv::Mat masks = empty_masks();
  EXPECT_TRUE(silhouettes(masks, {}, kCamera, {}).empty());
  masks.at<std::uint16_t>(50, 60) = 9;
  EXPECT_TRUE(silhouettes(masks, {}, kCamera, {}).empty());
  SilhouetteOptions options;
  options.min_pixels = 1;
  const Silhouette pixel = only(masks, {}, options);
  EXPECT_NEAR(pixel.bbox[0].offset_px, 60.5, 1e-9);
  EXPECT_NEAR(pixel.bbox[3].offset_px, -49.5, 1e-9);
  EXPECT_GT(pixel.rot_bbox.semi_minor, 0);
  masks(cv::Rect(40, 50, 60, 1)).setTo(9);  // a line of pixels
  const Silhouette line = only(masks, {}, options);
  EXPECT_NEAR(line.rot_bbox.semi_major, 30, 1e-9);
  EXPECT_NEAR(line.rot_bbox.semi_minor, 0.5, 1e-9);
  masks.setTo(9);  // the whole image: every line is its border
  for (const SupportLine& side : only(masks).support) EXPECT_FALSE(side.free);
}

// Smooth noise of unit variance with autocorrelation exp(-r^2 / (2 length^2)), from random plane waves whose
// wave vectors have that function's spectrum.
class SmoothNoise {
 public:
  SmoothNoise(double length_px, std::uint32_t element) {
    RandomStream random(3, "smooth_noise", 0, element);
    for (int i = 0; i < kWaves; ++i)
      waves_.push_back(
          {{random.normal() / length_px, random.normal() / length_px}, random.uniform(0, 2 * kPi)});
  }
  double operator()(const Eigen::Vector2d& p) const {
    double sum = 0;
    for (const auto& [wave, phase] : waves_) sum += std::cos(wave.dot(p) + phase);
    return std::sqrt(2.0 / kWaves) * sum;
  }

 private:
  static constexpr int kWaves = 48;
  std::vector<std::pair<Eigen::Vector2d, double>> waves_;
};

// Mean error of the four sides of a noisy rectangle's RotBbox.
double mean_side_error_px(const SilhouetteOptions& options) {
  constexpr int kTrials = 12;
  double sum = 0;
  for (int i = 0; i < kTrials; ++i) {
    const double angle = 0.27 * i, half_x = 50.3, half_y = 30.6;
    const Eigen::Vector2d center(160.2, 120.7), x(std::cos(angle), std::sin(angle)), y(-x.y(), x.x());
    const SmoothNoise noise(15, i);
    cv::Mat masks = empty_masks();
    draw(masks, 1, [&](const Eigen::Vector2d& p) {
      const double dx = std::abs(x.dot(p - center)) - half_x, dy = std::abs(y.dot(p - center)) - half_y;
      const double outside = std::max(dx, dy);
      return outside < -6 || (outside < 6 && outside <= noise(p));  // six sigma
    });
    const Silhouette silhouette = only(masks, {}, options);
    sum += silhouette.rot_bbox.semi_major - half_x + silhouette.rot_bbox.semi_minor - half_y;
  }
  return sum / (2 * kTrials);
}

// The outermost of a noisy side lies outside of it by more than a sigma of 1 px; the expected part of that is
// taken off.
TEST(Silhouette, TheBiasOfNoisySidesIsTakenOff) {
  SilhouetteOptions noisy;
  noisy.outline_noise_px = 1;
  EXPECT_GT(mean_side_error_px({}), 1.0);
  EXPECT_LT(std::abs(mean_side_error_px(noisy)), 0.4);
}

}  // namespace
}  // namespace uniquadric
