#include "estimator/perception/scan_objects.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <set>

#include "core/base/files.h"
#include "core/base/random.h"
#include "core/sequence/tracks.h"
#include "core/sequence/trajectory.h"
#include "estimator/estimate.h"
#include "tests/ego/lidar_room.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using Eigen::Vector3d;

// Points of an upright rectangle or a level one: from `low` to `high`, one of the extents being none.
void add_grid(const Vector3d& low, const Vector3d& high, double step_m, std::vector<Vector3d>& points) {
  const Eigen::Vector3i counts = ((high - low) / step_m).cast<int>();
  for (int i = 0; i <= counts.x(); ++i)
    for (int j = 0; j <= counts.y(); ++j)
      for (int k = 0; k <= counts.z(); ++k) points.push_back(low + step_m * Vector3d(i, j, k));
}

Eigen::Matrix3Xd matrix_of(const std::vector<Vector3d>& points) {
  Eigen::Matrix3Xd result(3, std::ssize(points));
  for (std::size_t i = 0; i < points.size(); ++i) result.col(static_cast<Eigen::Index>(i)) = points[i];
  return result;
}

TEST(LidarClusters, GroundIsTheSlopeUnderEverything) {
  std::vector<Vector3d> points;
  RandomStream random(1, "test");
  add_grid({-20, -20, 0}, {20, 20, 0}, 0.5, points);
  for (auto& p : points) p.z() = -2 + 0.05 * p.x() - 0.02 * p.y() + 0.02 * random.normal();
  add_grid({0, 0, 1.5}, {12, 12, 1.5}, 0.3, points);  // a roof, level and dense
  add_grid({-20, 8, -3}, {20, 8, 5}, 0.3, points);    // a wall
  const auto ground = find_ground(matrix_of(points), {}, 3, 0);
  ASSERT_TRUE(ground);
  for (const Vector3d& p : {Vector3d(-15, -15, 0), Vector3d(15, -15, 0), Vector3d(0, 5, 0)})
    EXPECT_NEAR(ground->height_of(p), 2 - 0.05 * p.x() + 0.02 * p.y(),
                0.08);  // m: the lowest points lie lower
  std::vector<Vector3d> wall;
  add_grid({-20, 8, -3}, {20, 8, 5}, 0.3, wall);
  EXPECT_FALSE(find_ground(matrix_of(wall), {}, 3, 0));
}

TEST(LidarClusters, BodiesApartFromWallsAndKerbs) {
  std::vector<Vector3d> points;
  add_grid({0, 0, 0}, {0, 2, 1.5}, 0.2, points);
  const auto first = std::ssize(points);
  add_grid({0, 3.1, 0}, {0, 5, 1.5}, 0.2, points);  // 1.1 m from the first one
  const auto second = std::ssize(points);
  add_grid({8, -20, 0}, {8, 20, 4}, 0.2, points);     // a wall
  add_grid({4, 0, 0}, {4, 4, 0.3}, 0.2, points);      // a kerb
  add_grid({20, 0, 0}, {20, 0.4, 0.6}, 0.3, points);  // too few points
  const auto clusters = clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.3}, {});
  ASSERT_EQ(clusters.size(), 2u);
  EXPECT_EQ(std::ssize(clusters[0]), first);
  EXPECT_EQ(std::ssize(clusters[1]), second - first);
  EXPECT_EQ(clusters[1].front(), first);
  LidarClusterOptions wide;
  wide.tolerance_m = 1.8;
  EXPECT_EQ(clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.3}, wide).size(), 1u);
  // what hangs in the air stands on no ground
  EXPECT_EQ(clusters_above(matrix_of(points), GroundPlane{{0, 0}, -0.6}, {}).size(), 0u);
}

// 2 degrees apart, as a VLP-16's: 1.4 m at 40 m.
TEST(LidarClusters, RowsOfASpinningLidarHangTogetherOnABody) {
  const double gap_rad = 2 * std::numbers::pi / 180;
  RandomStream random(1, "test");
  std::vector<Vector3d> points;
  std::vector<double> elevations_rad, rises_m;
  for (int row = -8; row < 8; ++row)
    for (int i = 0; i < 400; ++i) {
      elevations_rad.push_back(gap_rad * (row + 0.025 * random.normal()));
      const double range_m = 40, across_m = 0.14 * (i % 15), up_m = range_m * elevations_rad.back();
      points.emplace_back(range_m, (i % 2 ? 0 : 5) + across_m, up_m);  // two of them, 3 m apart
    }
  const std::vector<double> gaps = row_gaps(elevations_rad);
  for (const double gap : gaps) {
    EXPECT_NEAR(gap, gap_rad, 0.1 * gap_rad);
    rises_m.push_back(40 * gap);
  }
  LidarClusterOptions options;
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options).size(), 0u);  // each row is too low
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options, {rises_m, {}}).size(), 2u);
  options.max_rise_m = 1;  // each row is a body of its own, which may be as high as the next row is away
  EXPECT_EQ(clusters_above(matrix_of(points), {}, options, {rises_m, {}}).size(), 32u);
  // A rosette, of which few beams go beyond its rim.
  for (double& elevation : elevations_rad) elevation = random.uniform(-0.5, 0.5);
  for (int i = 0; i < 20; ++i) elevations_rad[i] = 0.52 + 0.0002 * random.normal();
  for (const double gap : row_gaps(elevations_rad)) EXPECT_EQ(gap, 0);
}

// The side of a truck 40 m ahead, 8 m beside the way: beams 0.2 degrees apart meet it every 0.7 to 0.9 m.
TEST(LidarClusters, ASideThatIsMetAtAGrazingAngleHangsTogether) {
  const double step_rad = 0.2 * std::numbers::pi / 180;
  std::vector<Vector3d> points;
  std::vector<double> azimuths_rad, elevations_rad, steps_m;
  for (int row = 0; row < 5; ++row)
    for (double azimuth = std::atan2(8, 46); azimuth < std::atan2(8, 36); azimuth += step_rad) {
      points.emplace_back(8 / std::tan(azimuth), 8, 0.3 * row);
      azimuths_rad.push_back(azimuth);
      elevations_rad.push_back(0.007 * row);
      steps_m.push_back(step_rad * points.back().norm());
    }
  EXPECT_NEAR(beam_step(azimuths_rad, elevations_rad), step_rad, 1e-9);
  const auto apart = clusters_above(matrix_of(points), {}, {});
  ASSERT_FALSE(apart.empty());
  EXPECT_LT(apart[0].size(), points.size() - 10);
  const auto together = clusters_above(matrix_of(points), {}, {}, {{}, steps_m});
  ASSERT_EQ(together.size(), 1u);
  EXPECT_EQ(together[0].size(), points.size());
}

// Places that no integer counts are cells like others.
TEST(LidarClusters, PointsOfNoPlaceLeaveTheOthersAsTheyAre) {
  std::vector<Vector3d> points;
  add_grid({-20, -20, 0}, {20, 20, 0}, 0.5, points);
  add_grid({0, 0, 0.3}, {0, 2, 1.5}, 0.2, points);
  const auto good = std::ssize(points);
  const auto body = [&] {
    const Eigen::Matrix3Xd all = matrix_of(points);
    return clusters_above(all, find_ground(all, {}, 3, 0), {});
  };
  const auto expected = body();
  ASSERT_EQ(expected.size(), 1u);
  for (const double far : {1e12, -1e12})  // their mean would be in the body's middle
    points.insert(points.end(), 20, Vector3d(far, 0, 1));
  EXPECT_EQ(body(), expected);
  EXPECT_LT(expected[0].back(), good);
}

ClusterBox box_at(double x, double y, double length_m = 4, double width_m = 2) {
  return {{x - length_m / 2, y - width_m / 2, 0}, {x + length_m / 2, y + width_m / 2, 1.5}, {}};
}

std::int64_t stamp(int scan) {
  return 100'000'000 * std::int64_t{scan};
}

TEST(ClusterTracker, BodiesKeepTheirIdsAndVelocitiesAsTheyPass) {
  ClusterTracker tracker{{}};
  std::array<int, 2> ids{};
  for (int i = 0; i < 40; ++i) {
    const double t = 0.1 * i;
    std::vector<ClusterBox> boxes = {box_at(5 * t, 0), box_at(20 - 8 * t, 3)};
    if (i % 2) std::swap(boxes[0], boxes[1]);  // no order is promised
    const bool hidden = i > 20 && i < 25;      // the second one
    if (hidden) boxes.erase(boxes.begin() + (i % 2 ? 0 : 1));
    const auto tracked = tracker.track(stamp(i), boxes);
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      const int which = boxes[k].low.y() < 0 ? 0 : 1;
      if (i == 0) ids[which] = tracked[k].id;
      EXPECT_EQ(tracked[k].id, ids[which]) << i;
      EXPECT_EQ(tracked[k].seen_as_body > 0, i >= 6) << i;
      if (i >= 2) {
        EXPECT_NEAR(tracked[k].velocity_mps.x(), which ? -8 : 5, 1e-9);
        EXPECT_NEAR(tracked[k].velocity_mps.y(), 0, 1e-9);
      }
    }
  }
}

TEST(ClusterTracker, WhatIsUncoveredOrStandsIsNoBody) {
  ClusterTracker tracker{{}};
  for (int i = 0; i < 20; ++i) {
    const double t = 0.1 * i;
    ClusterBox uncovered = box_at(0, 0), entering = box_at(20, 0);
    uncovered.high.x() += 2 * t;  // one end stays, a shadow's goes
    entering.high.x() += 2 * t;   // one end is that of the view: the other one tells
    entering.cut = {true, false, false, false};
    const auto tracked = tracker.track(stamp(i), {uncovered, entering, box_at(40, 0)});
    for (const TrackedCluster& cluster : tracked) EXPECT_EQ(cluster.seen_as_body, 0);
    if (i < 2) continue;
    EXPECT_NEAR(tracked[1].velocity_mps.x(), 2, 1e-9);
  }
  ClusterTrackerOptions all;
  all.moving_only = false;
  ClusterTracker any{all};
  for (int i = 0; i < 6; ++i)
    EXPECT_EQ(any.track(stamp(i), {box_at(40, 0)})[0].seen_as_body, std::max(0, i - 3));
}

// Of a car that is overtaken the far end is where the rows of the LiDAR last met its roof.
TEST(ClusterTracker, WhatShowsOneEndMovesWithIt) {
  ClusterTracker tracker{{}};
  RandomStream random(2, "test");
  int first_body = 0;
  for (int i = 0; i < 20; ++i) {
    ClusterBox box = box_at(20 + 0.8 * i, 0);
    box.high.x() = box.low.x() + random.uniform(0.5, 4);
    box.hidden[1] = true;
    ClusterBox still = box_at(20, 10);
    still.high.x() = still.low.x() + random.uniform(0.5, 4);
    still.low.x() += 0.1 * random.normal();
    still.hidden[1] = true;
    const auto tracked = tracker.track(stamp(i), {box, still});
    if (tracked[0].seen_as_body > 0 && first_body == 0) first_body = i;
    EXPECT_EQ(tracked[1].seen_as_body, 0) << i;
    if (i >= 2) {
      EXPECT_NEAR(tracked[0].velocity_mps.x(), 8, 1e-9) << i;
    }
  }
  EXPECT_GE(first_body, 4);
  EXPECT_LE(first_body, 8);
}

// Ends that were seen early and late in a scan by turns.
TEST(ClusterTracker, EndsAreWhereTheyWereAtTheirOwnTime) {
  ClusterTracker tracker{{}};
  for (int i = 0; i < 10; ++i) {
    const double ago_s = i % 2 ? 0.1 : 0;
    ClusterBox box = box_at(5 + 8 * (0.1 * i - ago_s), 0);
    box.ago_s = {ago_s, ago_s, ago_s, ago_s};
    const auto tracked = tracker.track(stamp(i), {box});
    if (i >= 2) {
      EXPECT_NEAR(tracked[0].velocity_mps.x(), 8, 1e-9) << i;
    }
  }
}

// The front of a car alone, 2.5 m nearer with each scan, among others that stand.
TEST(ClusterTracker, WhatIsFasterThanItIsLongIsFollowed) {
  ClusterTracker tracker{{}};
  const auto boxes = [](int i) {
    ClusterBox front = box_at(60 - 2.5 * i, 0, 0.4, 1.8);
    front.hidden[1] = true;
    return std::vector{box_at(60, 4), front, box_at(50, -4), box_at(40, 5)};
  };
  int id = 0;
  for (int i = 0; i < 12; ++i) {
    const auto tracked = tracker.track(stamp(i), boxes(i));
    if (i == 0) id = tracked[1].id;
    EXPECT_EQ(tracked[1].id, id) << i;
    EXPECT_EQ(tracked[1].seen_as_body > 0, i >= 6) << i;
    if (i > 0) {
      EXPECT_NEAR(tracked[1].velocity_mps.x(), -25, 1e-9) << i;
    }
    for (const int other : {0, 2, 3}) EXPECT_EQ(tracked[other].seen_as_body, 0);
  }
}

// A box comes through a room towards a swaying LiDAR, which has no camera.
class LidarAlone : public testing::Test {
 protected:
  LidarAlone() {
    room_.pattern = LidarRoom::Pattern::forward;
    room_.points = 20'000;
    room_.range_sigma_m = 0.01;
    room_.vigour = 0.3;
    room_.mover_half_m = {0.7, 0.5, 0.6};
    room_.half_size_m.x() = 12;
    room_.mover_start_m = {9, -1.4, -1.88};
    room_.mover_velocity_mps = {-1.5, 0, 0};
    Sequence sequence;
    sequence.name = "room";
    sequence.rate_hz = 10;
    sequence.lidar.emplace();
    sequence.lidar->pattern = "forward";
    sequence.lidar->camera_from_lidar = {Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5), {0.1, 0.2, -0.05}};
    std::filesystem::create_directories(temp_.path() / "sequence/lidar");
    for (int i = 0; i < kScans; ++i) {
      sequence.scans.push_back({room_.scan_start_ns(i), fmt::format("lidar/{}.pcd", i)});
      write_lidar_points(folder() / sequence.scans.back().file, room_.scan(i));
    }
    write_sequence_index(folder(), sequence);
    std::filesystem::remove(folder() / "rgb.txt");
    variant_ =
        load_variant(std::filesystem::path(UNIQUADRIC_SOURCE_DIR) / "configs/variants/lidar_only.yaml");
    variant_.perception.scan_objects.clusters.tolerance_m = 0.3;
    variant_.perception.scan_objects.clusters.max_extent_m = 4;
  }
  std::filesystem::path folder() const { return temp_.path() / "sequence"; }
  Pose room_from_camera(std::int64_t stamp_ns) const {
    return room_.world_from_lidar(1e-9 * static_cast<double>(stamp_ns)) *
           open_sequence(folder()).lidar->camera_from_lidar.inverse();
  }
  // Distance of a point from the moving box's surface.
  double off_mover_m(const Vector3d& point, std::int64_t stamp_ns) const {
    const Eigen::Array3d off = (point - room_.mover_m(1e-9 * static_cast<double>(stamp_ns))).array().abs() -
                               room_.mover_half_m.array();
    return off.maxCoeff() > 0 ? off.max(0).matrix().norm() : -off.maxCoeff();
  }

  // The rectangle about the mover in the camera's image.
  cv::Rect box_of_mover(const Camera& camera, std::int64_t stamp_ns) const {
    std::vector<cv::Point2f> corners;
    for (int i = 0; i < 8; ++i) {
      const Vector3d sign(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1);
      const Vector3d corner = room_.mover_start_m + sign.cwiseProduct(room_.mover_half_m);
      const auto pixel = camera.project(room_from_camera(stamp_ns).inverse() * corner);
      corners.emplace_back(static_cast<float>(pixel.value().x()), static_cast<float>(pixel.value().y()));
    }
    return cv::boundingRect(corners);
  }

  // The mover rests before a camera, whose images show it red and near before grey, with its masks or without
  // them. Its box in one of them.
  cv::Rect rest_before_images(bool with_masks) {
    room_.mover_velocity_mps = Vector3d::Zero();
    Sequence sequence = open_sequence(folder());
    for (int i = 0; i < kScans; ++i) write_lidar_points(folder() / sequence.scans[i].file, room_.scan(i));
    sequence.camera = scan_camera({});
    sequence.depth_units_per_m = 1000;
    const cv::Size size(sequence.camera.width, sequence.camera.height);
    for (const char* name : {"rgb", "depth", "masks"}) std::filesystem::create_directories(folder() / name);
    for (int i = 0; i < kScans; ++i) {
      SequenceFrame frame;
      frame.frame = i;
      frame.stamp_ns = frame.masks_arrival_ns = room_.scan_start_ns(i + 1);
      const cv::Rect box = box_of_mover(sequence.camera, frame.stamp_ns);
      cv::Mat image(size, CV_8UC3, cv::Scalar(90, 90, 90)), mask(size, CV_16UC1, cv::Scalar(0));
      image(box) = cv::Scalar(20, 20, 200);
      mask(box) = 1;
      const double away_m = (room_from_camera(frame.stamp_ns).inverse() * room_.mover_start_m).z();
      cv::Mat depth(size, CV_16UC1, cv::Scalar(2 * away_m * sequence.depth_units_per_m));
      depth(box) = cv::Scalar(away_m * sequence.depth_units_per_m);
      frame.rgb = fmt::format("rgb/{}.png", i);
      frame.depth = fmt::format("depth/{}.png", i);
      write_png(folder() / frame.rgb, image);
      write_png(folder() / frame.depth, depth);
      if (with_masks) write_png(folder() / (frame.masks = fmt::format("masks/{}.png", i)), mask);
      sequence.frames.push_back(frame);
    }
    write_sequence_index(folder(), sequence);
    return box_of_mover(sequence.camera, sequence.frames[kPrompted].stamp_ns);
  }

  // The estimate has the mover at its place, in nearly all scans from one on, and nothing else; or nothing at
  // all.
  void expect_mover_alone(bool is_found, const Prompts& prompts = {}, int from = 0) {
    EstimateOptions options;
    options.quiet = true;
    options.threads = 1;
    options.prompts = prompts;
    variant_.plausibility.enabled = false;
    const auto out = temp_.path() / (is_found ? "found" : "none");
    estimate(folder(), variant_, options, out);
    const Tracks tracks = read_tracks(out);
    const Pose room_from_world =
        room_from_camera(tracks.camera.back().stamp_ns) * tracks.camera.back().pose.inverse();
    const auto is_mover = [&](const ObjectTrack& track) {
      const Ellipsoid& last = track.states.back().ellipsoid;
      return std::ssize(track.states) >= kScans - from - 4 &&
             (room_from_world * last.world_from_object.translation - room_.mover_start_m).norm() < 0.3;
    };
    EXPECT_EQ(std::ssize(tracks.objects), is_found ? 1 : 0);
    EXPECT_EQ(std::ranges::count_if(tracks.objects, is_mover), is_found ? 1 : 0);
  }

  static constexpr int kScans = 26, kPrompted = 5;
  TempFolder temp_;
  LidarRoom room_;
  Variant variant_;
};

TEST_F(LidarAlone, PointsOfTheBodyLieOnItAtTheScansEnd) {
  EstimateOptions options;
  options.quiet = true;
  options.threads = 1;
  options.perception = temp_.path() / "perception";
  keep_perception(folder(), variant_, options);
  const Perception perception(options.perception);
  std::set<int> ids;
  int seen = 0;
  std::vector<double> off_m;
  for (std::size_t i = 0; i < perception.frames().size(); ++i) {
    const PerceivedFrame frame = perception.read(i);
    EXPECT_EQ(frame.stamp_ns, room_.scan_start_ns(static_cast<int>(i) + 1));
    for (const BodyObservation& body : frame.bodies) {
      ids.insert(body.id);
      ++seen;
      EXPECT_EQ(std::ssize(body.cut), body.points.cols());
      EXPECT_GT(body.points.cols(), 100);
      EXPECT_GE(body.known_at_frame, frame.frame);
      const Pose pose = room_from_camera(frame.stamp_ns);
      for (const auto& p : body.points.colwise())
        off_m.push_back(off_mover_m(pose * Vector3d(p), frame.stamp_ns));
    }
  }

  EXPECT_EQ(ids.size(), 1u);
  EXPECT_GE(seen, kScans - 8);
  ASSERT_FALSE(off_m.empty());
  std::sort(off_m.begin(), off_m.end());
  constexpr double kOff = 0.02;  // m: without its motion undone the front is 75 mm off in the middle
  EXPECT_LT(off_m[off_m.size() / 2], kOff);
}

TEST_F(LidarAlone, TheBodyIsFoundWithItsSize) {
  EstimateOptions options;
  options.quiet = true;
  options.threads = 1;
  const auto out = temp_.path() / "estimate";
  estimate(folder(), variant_, options, out);
  const Tracks tracks = read_tracks(out / "final");
  ASSERT_EQ(tracks.objects.size(), 1u);
  const ObjectTrack& track = tracks.objects[0];
  EXPECT_GE(std::ssize(track.states), kScans - 4);  // once it is known to move, it has been seen before
  EXPECT_LT(read_tracks(out).objects[0].states.size(), track.states.size());
  const ObjectState& last = track.states.back();
  std::array<double, 3> axes, truth{0.5, 0.6, 0.7};
  std::copy_n(last.ellipsoid.semi_axes_m.data(), 3, axes.begin());
  std::sort(axes.begin(), axes.end());
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(axes[i], truth[i], 0.15);
  // the step from first to last is free of what the world's origin is
  const Vector3d step = tracks.camera.back().pose.rotation.conjugate() *
                        (last.ellipsoid.world_from_object.translation -
                         track.states.front().ellipsoid.world_from_object.translation);
  const double time_s = 1e-9 * static_cast<double>(last.stamp_ns - track.states.front().stamp_ns);
  const Vector3d expected =
      room_from_camera(last.stamp_ns).rotation.conjugate() * (time_s * room_.mover_velocity_mps);
  EXPECT_LT((step - expected).norm(), 0.1);
}

// What rests is a body under a mask alone.
TEST_F(LidarAlone, WhatRestsUnderAMaskIsABody) {
  rest_before_images(true);
  for (const bool masks : {false, true}) {
    variant_.perception.scan_objects.masks = masks;
    expect_mover_alone(masks);
  }
}

// A segmenter that looks at colours gets them, though nothing else reads them.
TEST_F(LidarAlone, ABoxInAnImageTellsWhatIsABody) {
  const cv::Rect box = rest_before_images(false);
  const auto prompts = temp_.path() / "prompts.txt";
  write_text(prompts, fmt::format("{} {} {} {} {} 1\n", format_stamp(room_.scan_start_ns(kPrompted + 1)),
                                  box.x, box.y, box.width, box.height));
  variant_.perception.scan_objects.masks = true;
  expect_mover_alone(true, prompts, kPrompted);
}

}  // namespace
}  // namespace uniquadric
