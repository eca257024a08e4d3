#include "estimator/lidar/lidar_depth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/random.h"
#include "estimator/lidar/pixel_grid.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

constexpr double kWall = 12, kBoard = 8;  // depths [m]
constexpr double kSpeed = 10;             // of the board, to the right or towards the camera [m/s]
constexpr std::int64_t kScan = 100'000'000, kFrame = 33'333'333;

Camera small_camera() {
  Camera camera;
  camera.width = 320, camera.height = 240;
  camera.fx = camera.fy = 230, camera.cx = 159.5, camera.cy = 119.5;
  return camera;
}

double gone_m(std::int64_t stamp_ns) {
  return kSpeed * 1e-9 * static_cast<double>(stamp_ns);
}

double board_x(std::int64_t stamp_ns) {
  return gone_m(stamp_ns) - 2;
}

bool on_board(const Eigen::Vector2d& ray, std::int64_t stamp_ns) {
  return std::abs(kBoard * ray.x() - board_x(stamp_ns)) < 1 && std::abs(kBoard * ray.y()) < 0.7;
}

// One that comes nearer, from beside the wall.
double near_depth(std::int64_t stamp_ns) {
  return kWall - 1 - gone_m(stamp_ns);
}

bool on_near_board(const Eigen::Vector2d& ray, std::int64_t stamp_ns) {
  return (near_depth(stamp_ns) * ray).cwiseAbs().maxCoeff() < 1;
}

using OnBoard = std::function<bool(const Eigen::Vector2d&, std::int64_t)>;

cv::Mat mask_at(const Camera& camera, std::int64_t stamp_ns, const OnBoard& on = on_board) {
  cv::Mat mask = cv::Mat::zeros(camera.height, camera.width, CV_16UC1);
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (on(camera.unproject({u, v})->head<2>(), stamp_ns)) mask.at<std::uint16_t>(v, u) = 7;
  return mask;
}

// A board that passes before a wall; the LiDAR sits in the camera and looks where it does, 24,000 points a
// scan, each at its own time, in the file in no order of time; every tenth beam comes back empty.
Sequence passing_board(
    const std::filesystem::path& folder, const OnBoard& on = on_board,
    const std::function<double(std::int64_t)>& depth = [](auto) { return kBoard; }) {
  Sequence sequence;
  sequence.folder = folder;
  sequence.camera = small_camera();
  sequence.lidar = LidarCalibration{};
  for (int k = 0; k < 4; ++k) {
    RandomStream random(1, "scan", static_cast<std::uint64_t>(k));
    std::vector<LidarPoint> points(24000);
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].offset_ns = static_cast<std::uint32_t>(random.uniform() * kScan);
      const Eigen::Vector2d ray(random.uniform(-0.69, 0.69), random.uniform(-0.52, 0.52));
      const std::int64_t stamp_ns = k * kScan + points[i].offset_ns;
      const double z = on(ray, stamp_ns) ? depth(stamp_ns) : kWall;
      if (i % 10 == 0) continue;
      points[i].x = static_cast<float>(z * ray.x());
      points[i].y = static_cast<float>(z * ray.y());
      points[i].z = static_cast<float>(z);
    }
    sequence.scans.push_back({k * kScan, std::to_string(k) + ".pcd"});
    write_lidar_points(folder / sequence.scans.back().file, points);
  }
  return sequence;
}

// A sequence's frames one by one.
struct ByFrames {
  FramePointSource source;
  LidarDepth depth;

  explicit ByFrames(const Sequence& sequence, const LidarDepthOptions& options = {})
      : source(
            sequence, [](std::int64_t) { return Pose(); }, frame_point_options(options)),
        depth(sequence, options) {}

  LidarView at(std::int64_t stamp_ns, const cv::Mat& masks) {
    const FramePoints points = source.take(stamp_ns, stamp_ns + kFrame, masks);
    return depth.at(points, masks, depth.background(points, masks));
  }
};

struct Seen {
  double left = 0, right = 0, depth_error = 0;  // of the board's points [m], less where they are
  int points = 0;
};

Seen look(Undistortion undistortion, bool told) {
  const TempFolder temp;
  const Sequence sequence = passing_board(temp.path());
  LidarDepthOptions options;
  options.undistortion = undistortion;
  options.motion = MotionSource::features;
  ByFrames frames(sequence, options);
  LidarView view;
  std::int64_t now = 0;
  for (int k = 0; k < 9; ++k) {
    now = k * kFrame;
    view = frames.at(now, mask_at(sequence.camera, now));
    if (told) frames.depth.moved(7, {Eigen::Quaterniond::Identity(), {kSpeed * 1e-9 * kFrame, 0, 0}}, kFrame);
  }
  Seen seen;
  const Eigen::Matrix3Xd& points = view.bodies.at(7).points;
  seen.points = static_cast<int>(points.cols());
  seen.left = points.row(0).minCoeff() - (board_x(now) - 1);
  seen.right = points.row(0).maxCoeff() - (board_x(now) + 1);
  seen.depth_error = (points.row(2).array() - kBoard).abs().maxCoeff();
  return seen;
}

TEST(LidarDepth, Eq4_PointsOfABodyLieWhereItIsAtTheFrame) {
  const Seen seen = look(Undistortion::object, true);
  EXPECT_GT(seen.points, 500);
  EXPECT_LT(seen.depth_error, 1e-6);
  EXPECT_NEAR(seen.left, 0, 0.12);  // the mask's rim, and the points are 5 cm apart
  EXPECT_NEAR(seen.right, 0, 0.12);
}

TEST(LidarDepth, WithoutABodysMotionItsPointsTrailBehind) {
  const Seen seen = look(Undistortion::ego, true);
  const Seen with = look(Undistortion::object, true);
  EXPECT_LT(seen.points, 0.9 * with.points);  // they have left the mask, or the mask shows the wall there
}

TEST(LidarDepth, PointsThemselvesTellHowFastABodyComesNearer) {
  const TempFolder temp;
  const Sequence sequence = passing_board(temp.path(), on_near_board, near_depth);
  ByFrames frames(sequence);
  int looked_at = 0;
  for (int k = 0; k < 12; ++k) {
    const std::int64_t now = k * kFrame;
    const LidarView view = frames.at(now, mask_at(sequence.camera, now, on_near_board));
    if (k < 4) continue;  // the first points are of one time
    const Eigen::Matrix3Xd& points = view.bodies.at(7).points;
    EXPECT_GT(points.cols(), 300);
    EXPECT_LT((points.row(2).array() - near_depth(now)).abs().maxCoeff(), 0.02);  // 0.5 m behind without
    ++looked_at;
  }
  EXPECT_EQ(looked_at, 8);
}

TEST(LidarDepth, FeaturesTellHowFastABodyPasses) {
  const TempFolder temp;
  const Sequence sequence = passing_board(temp.path());
  ByFrames frames(sequence);
  LidarView view;
  std::int64_t now = 0;
  for (int k = 0; k < 9; ++k) {
    now = k * kFrame;
    view = frames.at(now, mask_at(sequence.camera, now));
    std::map<int, std::vector<Feature>> features;
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d at(board_x(now) - 0.9 + 0.09 * i, 0.6 * std::sin(5.0 * i), kBoard);
      features[7].push_back({i, *sequence.camera.project(at), kBoard, 0.01});
    }
    frames.depth.saw(features);
  }
  const Eigen::Matrix3Xd& points = view.bodies.at(7).points;
  EXPECT_NEAR(points.row(0).minCoeff(), board_x(now) - 1, 0.12);
  EXPECT_NEAR(points.row(0).maxCoeff(), board_x(now) + 1, 0.12);
}

TEST(LidarDepth, AMotionToldLongAgoIsForgotten) {
  const TempFolder temp;
  const Sequence sequence = passing_board(temp.path());
  LidarDepthOptions options;
  options.motion = MotionSource::features;
  ByFrames told(sequence, options), untold(sequence, options);
  int differ = 0, agree = 0;
  for (int k = 0; k < 11; ++k) {
    const std::int64_t now = k * kFrame;
    const cv::Mat mask = mask_at(sequence.camera, now);
    const auto points = [&](ByFrames& frames) { return frames.at(now, mask).bodies[7].points; };
    const Eigen::Matrix3Xd with = points(told), without = points(untold);
    const bool same = with.cols() == without.cols() && with == without;
    if (k == 2) told.depth.moved(7, {Eigen::Quaterniond::Identity(), {0, 0, 0.1}}, kFrame);
    if (k == 3 || k == 4) differ += !same;  // it counts for two frames
    if (k >= 8) agree += same;              // when the points that it moved are out of the window
  }
  EXPECT_EQ(differ, 2);
  EXPECT_EQ(agree, 3);
}

TEST(LidarDepth, DepthIsThatOfThePlanesAlongTheLinesOfSight) {
  const TempFolder temp;
  const Sequence sequence = passing_board(temp.path());
  ByFrames frames(sequence);
  const std::int64_t now = 6 * kFrame;
  const cv::Mat mask = mask_at(sequence.camera, now);
  LidarView view;
  for (int k = 0; k <= 6; ++k) view = frames.at(k * kFrame, mask_at(sequence.camera, k * kFrame));
  int known = 0, all = 0;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      if (mask.at<std::uint16_t>(v, u) != 7) continue;
      ++all;
      const float z = view.depth.at<float>(v, u);
      if (!(z > 0)) continue;
      EXPECT_NEAR(z, kBoard, 1e-3);
      ++known;
    }
  EXPECT_GT(all, 1000);
  EXPECT_GT(known, 0.9 * all);
}

TEST(PointPlanes, NeighboursAcrossAJumpAreLeftOutAndSlantsKept) {
  RandomStream random(2, "planes");
  std::vector<ImagePoint> points;
  const auto inverse_depth = [](const Eigen::Vector2d& p) { return p.x() < 100 ? 0.1 + 1e-4 * p.y() : 0.05; };
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector2d pixel(random.uniform(0, 200), random.uniform(0, 150));
    points.push_back({pixel, inverse_depth(pixel)});
  }
  const std::vector<PointPlane> planes = point_planes(points, {});
  EXPECT_GT(planes.size(), 1900);
  for (const PointPlane& plane : planes) {
    EXPECT_NEAR(plane.inverse_depth, inverse_depth(plane.pixel), 1e-9);
    EXPECT_NEAR(plane.slope_per_px.y(), plane.pixel.x() < 100 ? 1e-4 : 0, 1e-9);
  }
}

// Rows 16 px apart of points 1.6 px apart, as a VLP-16's in an image of 460 px: the nearest of all lie in one
// row, which tells no slope across it.
TEST(PointPlanes, OfRowsFarApartAreLaidThroughSeveral) {
  const auto inverse_depth = [](const Eigen::Vector2d& p) { return 0.1 + 1e-5 * p.x() + 3e-5 * p.y(); };
  std::vector<ImagePoint> points;
  for (int row = 0; row < 5; ++row)
    for (int i = 0; i < 60; ++i) {
      const Eigen::Vector2d pixel(1.6 * i, 16.0 * row);
      points.push_back({pixel, inverse_depth(pixel)});
    }
  EXPECT_TRUE(point_planes(points, {}).empty());
  PointPlaneOptions options;
  options.row_gap_px = 16;
  const std::vector<PointPlane> planes = point_planes(points, options);
  EXPECT_EQ(planes.size(), points.size());
  for (const PointPlane& plane : planes) {
    EXPECT_NEAR(plane.inverse_depth, inverse_depth(plane.pixel), 1e-9);
    EXPECT_NEAR(plane.slope_per_px.y(), 3e-5, 1e-9);
  }
}

TEST(PointPlanes, SliversOfOtherThingsAreNotTheBody) {
  RandomStream random(3, "slivers");
  std::vector<ImagePoint> points;
  for (int i = 0; i < 500; ++i) points.push_back({{random.uniform(0, 80), random.uniform(0, 80)}, 0.1});
  for (int i = 0; i < 30; ++i) points.push_back({{random.uniform(80, 84), random.uniform(0, 80)}, 0.05});
  PointPlaneOptions options;
  options.one_body = true;
  for (const PointPlane& plane : point_planes(points, options)) EXPECT_NEAR(plane.inverse_depth, 0.1, 1e-9);
  options.one_body = false;
  EXPECT_GT(point_planes(points, options).size(), 510);
}

// The second way: all points sorted by their distance.
TEST(PixelGrid, FindsTheNearestOfAll) {
  RandomStream random(4, "grid");
  std::vector<ImagePoint> points;
  for (int i = 0; i < 1500; ++i)  // thin here, dense there
    points.push_back({{random.uniform(0, i % 2 ? 200 : 20), random.uniform(0, i % 2 ? 150 : 30)}, 0.1});
  points.push_back(points.front());  // the same place twice
  const PixelGrid grid(points, 14, 12);
  for (const std::size_t k : {1, 12})
    for (const ImagePoint& point : points) {
      std::vector<std::pair<double, std::size_t>> all;
      for (std::size_t i = 0; i < points.size(); ++i)
        if (const double d = (points[i].pixel - point.pixel).squaredNorm(); d <= 14 * 14)
          all.emplace_back(d, i);
      std::sort(all.begin(), all.end());
      all.resize(std::min(k, all.size()));
      std::vector<std::size_t> expected;
      for (const auto& [d, i] : all) expected.push_back(i);
      EXPECT_EQ(grid.nearest(point.pixel, k), expected);
    }
}

TEST(PixelGrid, OfACrowdInOnePlaceAFewStandForAll) {
  RandomStream random(5, "crowd");
  std::vector<ImagePoint> points;
  for (int i = 0; i < 30000; ++i)  // all within a pixel or two
    points.push_back({{50 + random.uniform(), 50 + random.uniform()}, 0.1 + 1e-4 * (i % 2)});
  const PixelGrid grid(points, 14, 12);
  EXPECT_LE(grid.nearest({50.5, 50.5}, points.size()).size(), 4 * 64u);
  EXPECT_EQ(PixelGrid(points, 14, 200).nearest({50.5, 50.5}, 200).size(), 200u);
  const std::vector<PointPlane> planes = point_planes(points, {});
  EXPECT_GT(planes.size(), 29000u);
  for (const PointPlane& plane : planes) EXPECT_NEAR(plane.inverse_depth, 0.10005, 2e-4);
}

TEST(LidarStream, CutsByThePointsOwnStampsAndPassesOverEmptyReturns) {
  const TempFolder temp;
  const Sequence sequence = on_camera_clock(passing_board(temp.path()), -1000);
  LidarStream stream(sequence);
  std::size_t count = 0;
  std::int64_t last = 0;
  for (std::int64_t until = kFrame; until < 5 * kScan; until += kFrame)
    for (const TimedPoint& p : stream.take(until)) {
      EXPECT_GE(p.stamp_ns, last);
      EXPECT_GT(p.stamp_ns, until - kFrame);
      EXPECT_LE(p.stamp_ns, until);
      EXPECT_FALSE(p.lidar.isZero());
      last = p.stamp_ns;
      ++count;
    }
  EXPECT_EQ(count, 4 * 24000 * 9 / 10);
}

}  // namespace
}  // namespace uniquadric
