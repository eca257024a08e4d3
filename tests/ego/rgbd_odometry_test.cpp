#include "estimator/ego/rgbd_odometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <numeric>

namespace uniquadric {
namespace {

// Points on the walls of a room, and a camera that walks a circle in it and looks outwards.
struct Walk {
  Camera camera;
  std::vector<Eigen::Vector3d> points;
  double pixel_sigma = 0, depth_share = 0;
  double radius_m = 0.8, turn_rad = 0.04;  // a frame

  explicit Walk(std::uint64_t seed) {
    RandomStream random(seed, "walk");
    for (int i = 0; i < 1500; ++i) {
      Eigen::Vector3d p(random.uniform(-3, 3), random.uniform(-3, 3), random.uniform(-1.5, 1.5));
      p[random.below(2)] = random.below(2) ? 3 : -3;
      points.push_back(p);
    }
  }

  Pose world_from_camera(int i) const {
    const double a = turn_rad * i;
    Eigen::Matrix3d R;  // columns: right, down, forward
    R.col(2) = Eigen::Vector3d(std::cos(a), std::sin(a), 0.1 * std::sin(3 * a)).normalized();
    R.col(0) = R.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
    R.col(1) = R.col(2).cross(R.col(0));
    return {Eigen::Quaterniond(R), {radius_m * std::cos(a), radius_m * std::sin(a), 0.05 * std::sin(2 * a)}};
  }

  Pose motion(int i) const { return relative_pose(world_from_camera(i), world_from_camera(i - 1)); }

  SequenceFrame frame(int i) const {
    SequenceFrame frame;
    frame.frame = i;
    frame.stamp_ns = i * 33'333'333LL;
    return frame;
  }

  TrackedFeatures see(int i) const {
    TrackedFeatures seen;
    RandomStream random(5, "see", i);
    const Pose camera_from_world = world_from_camera(i).inverse();
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Eigen::Vector3d p = camera_from_world * points[k];
      const auto pixel = camera.project(p);
      if (!pixel || !camera.contains(*pixel) || p.z() < 0.3) continue;
      Feature f;
      f.track = std::int64_t(k);
      f.pixel = *pixel + pixel_sigma * Eigen::Vector2d(random.normal(), random.normal());
      f.depth_m = p.z() * (1 + depth_share * random.normal());
      f.depth_sigma_m = p.z() * std::max(depth_share, 1e-3);
      seen.background.push_back(f);
    }
    return seen;
  }
};

struct Errors {
  double worst_m = 0, worst_rad = 0;
  int poses = 0;
};

// Relative to the first pose: the world's own frame is another matter.
Errors errors_of(const Walk& walk, const Trajectory& trajectory) {
  Errors errors;
  std::map<std::int64_t, int> frames;
  for (int i = 0; i < 1000; ++i) frames[walk.frame(i).stamp_ns] = i;
  const int first = frames.at(trajectory.at(0).stamp_ns);
  for (const auto& [stamp, pose] : trajectory) {
    const Pose estimate = relative_pose(trajectory[0].pose, pose);
    const Pose truth = relative_pose(walk.world_from_camera(first), walk.world_from_camera(frames.at(stamp)));
    errors.worst_m = std::max(errors.worst_m, (estimate.translation - truth.translation).norm());
    errors.worst_rad =
        std::max(errors.worst_rad, log_so3(estimate.rotation.conjugate() * truth.rotation).norm());
    ++errors.poses;
  }
  return errors;
}

TEST(RgbdOdometry, IsExactOnPerfectFeatures) {
  const Walk walk(1);
  RgbdOdometry odometry(walk.camera, {}, 1);
  for (int i = 0; i < 60; ++i) odometry.track(walk.frame(i), walk.see(i), {}, {});
  const Errors errors = errors_of(walk, odometry.trajectory());
  EXPECT_EQ(errors.poses, 60);
  EXPECT_LT(errors.worst_m, 1e-6);
  EXPECT_LT(errors.worst_rad, 1e-6);
}

TEST(RgbdOdometry, StaysWithinItsNoise) {
  Walk walk(2);
  walk.pixel_sigma = 0.15;
  walk.depth_share = 0.001;
  RgbdOdometry odometry(walk.camera, {}, 1);
  for (int i = 0; i < 90; ++i) odometry.track(walk.frame(i), walk.see(i), {}, {});
  const Errors errors = errors_of(walk, odometry.trajectory());
  EXPECT_EQ(errors.poses, 90);
  EXPECT_LT(errors.worst_m, 0.01);  // of a path of 2.9 m
  EXPECT_LT(errors.worst_rad, 0.004);
}

// Once around: the points of the beginning come back, and the end fits them.
TEST(RgbdOdometry, AFullCircleCloses) {
  Walk walk(3);
  walk.pixel_sigma = 0.15;
  walk.depth_share = 0.002;
  RgbdOdometry odometry(walk.camera, {}, 1);
  const int frames = int(2 * M_PI / walk.turn_rad) + 10;
  for (int i = 0; i < frames; ++i) odometry.track(walk.frame(i), walk.see(i), {}, {});
  const Trajectory trajectory = odometry.trajectory();
  ASSERT_EQ(std::ssize(trajectory), frames);
  const Pose estimate = relative_pose(trajectory.front().pose, trajectory.back().pose);
  const Pose truth = relative_pose(walk.world_from_camera(0), walk.world_from_camera(frames - 1));
  EXPECT_LT((estimate.translation - truth.translation).norm(), 0.004);
}

// More keyframes than a dense solver is asked for.
TEST(AdjustBundle, ManyKeyframesComeToTheTruth) {
  const Walk walk(5);
  EgoMap map;
  RandomStream random(5, "bundle");
  for (int i = 0; i < 180; i += 3) {
    const auto step = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
    const Pose error{exp_so3(0.002 * step()), 0.005 * step()};
    const Pose pose = walk.world_from_camera(i).inverse();
    add_keyframe(map, walk.camera, {i, i == 0 ? pose : error * pose, walk.see(i).background});
  }
  std::vector<int> all(map.keyframes.size());
  std::iota(all.begin(), all.end(), 0);
  BundleOptions options;
  options.iterations = 50;
  adjust_bundle(map, walk.camera, all, options);
  for (const Keyframe& keyframe : map.keyframes)
    EXPECT_LT(log_se3(keyframe.camera_from_world * walk.world_from_camera(int(keyframe.frame))).norm(), 1e-4);
}

// The path is bent as if the odometry had drifted, a random step a keyframe: old points that come back
// straighten it.
TEST(RgbdOdometry, ALoopMendsADrift) {
  const Walk walk(4);
  const int frames = int(2 * M_PI / walk.turn_rad) + 3, last = frames - 1;
  double middle_before = 0, middle_after = 0;
  for (int trial = 0; trial < 20; ++trial) {
    RandomStream random(9, "drift", trial);
    const auto step = [&](double size) -> Eigen::Vector3d {
      return size * Eigen::Vector3d(random.normal(), random.normal(), random.normal());
    };
    EgoMap map;
    Pose drifted = walk.world_from_camera(0).inverse();
    const auto go_on = [&](int from, int to) {  // a step of the true motion with an error of its own
      const Pose motion = walk.world_from_camera(to).inverse() * walk.world_from_camera(from);
      drifted = Pose{exp_so3(step(0.002)), step(0.003)} * motion * drifted;
    };
    for (int i = 0; i < last; i += 4) {
      Keyframe keyframe{i, drifted, walk.see(i).background};
      if (i > frames / 2)  // tracks that were lost have new ids
        for (auto& f : keyframe.features) f.track += 10'000;
      add_keyframe(map, walk.camera, keyframe);
      go_on(i, std::min(i + 4, last));
    }
    const auto seen = walk.see(last).background;  // under their first ids
    const LoopOptions options = EgoOptions{}.loop;
    const auto loop = find_loop(map, walk.camera, seen, drifted, options, random);
    ASSERT_TRUE(loop);
    EXPECT_FALSE(find_loop(map, walk.camera, seen, loop->camera_from_world, options, random));
    auto features = seen;
    for (auto& f : features) f.track += 10'000;
    features.insert(features.end(), seen.begin(), seen.end());
    add_keyframe(map, walk.camera, {last, drifted, features});
    const auto error = [&](std::size_t k) {
      const Keyframe& keyframe = map.keyframes[k];
      return log_se3(keyframe.camera_from_world * walk.world_from_camera(int(keyframe.frame))).norm();
    };
    const std::size_t end = map.keyframes.size() - 1;
    const double end_before = error(end);
    middle_before += error(end / 2);
    close_loop(map, *loop, options);
    EXPECT_LT(error(end), 0.5 * end_before);
    middle_after += error(end / 2);
  }
  // Half of a random walk whose end is known has half the variance of one whose end is not.
  EXPECT_LT(middle_after, 0.85 * middle_before);
}

TEST(RgbdOdometry, IsLostWithoutFeaturesAndFindsBack) {
  const Walk walk(5);
  RgbdOdometry odometry(walk.camera, {}, 1);
  EXPECT_FALSE(odometry.pose());
  EXPECT_TRUE(odometry.trajectory().empty());
  odometry.track(walk.frame(0), {}, {}, {});
  TrackedFeatures flat = walk.see(0);
  for (auto& f : flat.background) f.depth_m = f.depth_sigma_m = 0;
  odometry.track(walk.frame(1), flat, {}, {});
  EXPECT_FALSE(odometry.pose());
  for (int i = 2; i < 8; ++i) odometry.track(walk.frame(i), walk.see(i), {}, {});
  EXPECT_TRUE(odometry.pose());
  TrackedFeatures one = walk.see(8);
  one.background.resize(1);
  odometry.track(walk.frame(8), one, {}, {});
  EXPECT_FALSE(odometry.pose());
  odometry.track(walk.frame(9), {}, {}, {});
  EXPECT_FALSE(odometry.pose());
  odometry.track(walk.frame(10), walk.see(10), {}, {});
  ASSERT_TRUE(odometry.pose());
  const Errors errors = errors_of(walk, odometry.trajectory());
  EXPECT_EQ(errors.poses, 7);
  EXPECT_LT(errors.worst_m, 1e-6);
}

// The second frame has no depth: its pixels fit the wrong map as well as the true one.
TEST(RgbdOdometry, BeginsAnewWhenTheFirstFrameWasWrong) {
  const Walk walk(8);
  for (const double factor : {0.5, 2.0}) {
    RgbdOdometry odometry(walk.camera, {}, 1);
    for (int i = 0; i < 40; ++i) {
      TrackedFeatures seen = walk.see(i);
      for (auto& f : seen.background) {
        if (i == 0) f.depth_m *= factor;
        if (i == 1) f.depth_m = 0;
      }
      if (i > 0) seen.background_motion = walk.motion(i);
      odometry.track(walk.frame(i), seen, {}, {});
    }
    const Trajectory trajectory = odometry.trajectory();
    ASSERT_EQ(trajectory.size(), 39u) << factor;  // all but the first, which fits no map
    EXPECT_EQ(trajectory[0].stamp_ns, walk.frame(1).stamp_ns);
    EXPECT_LT(errors_of(walk, trajectory).worst_m, 1e-6);
    EXPECT_EQ(odometry.restarts(), 0);
  }
}

// From frame 40 on all depths are 8 % more: the world is larger from there, and the path in it.
TEST(RgbdOdometry, AStepOfTheScaleBeginsANewMapAtTheLastPose) {
  Walk walk(9);
  walk.turn_rad = 0.02;  // so that the last lost frames see what the first ones saw
  RgbdOdometry odometry(walk.camera, {}, 1);
  for (int i = 0; i < 100; ++i) {
    TrackedFeatures seen = walk.see(i);
    for (auto& f : seen.background) f.depth_m *= i < 40 ? 1 : 1.08;
    if (i > 0) seen.background_motion = walk.motion(i);
    odometry.track(walk.frame(i), seen, {}, {});
  }
  EXPECT_EQ(odometry.restarts(), 1);
  EXPECT_TRUE(odometry.pose());
  const Trajectory trajectory = odometry.trajectory();
  ASSERT_EQ(trajectory.size(), 100u);  // those that were bridged have a place in the new map
  EXPECT_EQ(odometry.causal_trajectory().size(), 100u);
  EXPECT_EQ(odometry.lagged_trajectory().size(), 100u);
  for (int i = 1; i < 100; ++i) {
    const Pose estimate = relative_pose(trajectory[i - 1].pose, trajectory[i].pose);
    const Pose truth = relative_pose(walk.world_from_camera(i - 1), walk.world_from_camera(i));
    const double scale = i < 40 ? 1 : 1.08;
    EXPECT_LT((estimate.translation - scale * truth.translation).norm(), i == 40 ? 0.15 : 1e-6) << i;
  }
}

// Told that depth has another scale, it does not wait until it is lost; told by a frame without depth, it
// begins with the next one that has.
TEST(RgbdOdometry, AChangeOfDepthThatIsKnownBeginsANewMapAtOnce) {
  const Walk walk(9);
  for (const bool is_blank : {false, true}) {
    RgbdOdometry odometry(walk.camera, {}, 1);
    for (int i = 0; i < 50; ++i) {
      TrackedFeatures seen = walk.see(i);
      for (auto& f : seen.background) f.depth_m *= i < 40 ? 1 : i == 40 && is_blank ? 0 : 1.08;
      if (i > 0) seen.background_motion = walk.motion(i);
      seen.depth_changed = i == 40;
      odometry.track(walk.frame(i), seen, {}, {});
      EXPECT_EQ(odometry.restarts(), i >= (is_blank ? 41 : 40) ? 1 : 0) << i;
    }
  }
}

// By those of frames whose keyframes still move; the frames' places stay.
TEST(RgbdOdometry, FeaturesThatAreKeptAreBounded) {
  Walk walk(2);
  walk.pixel_sigma = 0.15;
  walk.depth_share = 0.001;
  RgbdOdometry odometry(walk.camera, {}, 1);
  std::int64_t most_early = 0, most_late = 0;
  for (int i = 0; i < 300; ++i) {
    odometry.track(walk.frame(i), walk.see(i), {}, {});
    std::int64_t& most = i < 150 ? most_early : most_late;
    most = std::max(most, odometry.features_kept());
  }
  EXPECT_GT(most_early, 0);
  EXPECT_LT(most_late, 1.2 * static_cast<double>(most_early));
  EXPECT_LT(errors_of(walk, odometry.trajectory()).worst_m, 0.01);
}

// Features that are new in every frame: any map would be lost in the next one, and the first stays.
TEST(RgbdOdometry, WithoutFeaturesToFollowNoMapBeginsAnew) {
  const Walk walk(11);
  for (const int placed : {1, 20}) {
    RgbdOdometry odometry(walk.camera, {}, 1);
    for (int i = 0; i < 80; ++i) {
      TrackedFeatures seen = walk.see(i);
      if (i >= placed)
        for (auto& f : seen.background) f.track += 10'000 * i;
      odometry.track(walk.frame(i), seen, {}, {});
    }
    EXPECT_EQ(odometry.restarts(), 0);
    const Trajectory trajectory = odometry.trajectory();
    ASSERT_EQ(std::ssize(trajectory), placed);
    EXPECT_EQ(trajectory[0].stamp_ns, walk.frame(0).stamp_ns);
  }
}

TEST(RgbdOdometry, ACameraThatIsCoveredFindsBackToItsMap) {
  const Walk walk(10);
  RgbdOdometry odometry(walk.camera, {}, 1);
  for (int i = 0; i < 120; ++i) {
    TrackedFeatures seen = walk.see(0);
    if (i >= 30 && i < 90) seen.background.resize(10);
    odometry.track(walk.frame(i), seen, {}, {});
  }
  EXPECT_EQ(odometry.restarts(), 0);
  EXPECT_EQ(odometry.trajectory().size(), 60u);
}

// Each fifth point is followed under another id from frame 31 on; in frames 33 to 40 nothing else is seen,
// and no map knows it. The motion is 2 mm off there. From frame 41 on all points have both ids.
TrackedFeatures see_unknown(const Walk& walk, int i) {
  TrackedFeatures seen = walk.see(i), unknown;
  for (Feature f : seen.background) {
    if (f.track % 5 != 0 && i < 41) continue;
    f.track += 10'000;
    if (i >= 31) unknown.background.push_back(f);
  }
  if (i >= 33 && i < 41) seen.background.clear();
  seen.background.insert(seen.background.end(), unknown.background.begin(), unknown.background.end());
  if (i > 0) seen.background_motion = walk.motion(i);
  if (i >= 33 && i < 41) seen.background_motion->translation.x() += 0.002;
  return seen;
}

TEST(RgbdOdometry, FramesThatDoNotFitTheMapAreBridged) {
  Walk walk(12);
  walk.turn_rad = 0.004;  // so that no keyframe falls into frames 31 to 40
  for (const bool is_on : {true, false}) {
    EgoOptions options;
    if (!is_on) options.bridge_features = 0;
    RgbdOdometry odometry(walk.camera, options, 1);
    for (int i = 0; i < 50; ++i) {
      odometry.track(walk.frame(i), see_unknown(walk, i), {}, {});
      EXPECT_EQ(odometry.pose().has_value(), is_on || i < 33 || i >= 41) << i;
    }
    EXPECT_EQ(odometry.restarts(), 0);
    const Errors causal = errors_of(walk, odometry.causal_trajectory());
    const Errors later = errors_of(walk, odometry.trajectory());
    EXPECT_EQ(causal.poses, is_on ? 50 : 42);
    EXPECT_EQ(later.poses, causal.poses);
    EXPECT_EQ(std::ssize(odometry.lagged_trajectory()), causal.poses);
    EXPECT_NEAR(causal.worst_m, is_on ? 8 * 0.002 : 0, 1e-3);
    EXPECT_LT(later.worst_m, 1e-6);  // by then the map knows what they saw
  }
}

// Of too few features, or after a frame whose motion is not known.
TEST(RgbdOdometry, NothingIsBridgedWithoutAMotionThatIsKnown) {
  Walk walk(12);
  walk.turn_rad = 0.004;
  for (const bool are_few : {true, false}) {
    RgbdOdometry odometry(walk.camera, {}, 1);
    for (int i = 0; i < 36; ++i) {
      TrackedFeatures seen = see_unknown(walk, i);
      if (i >= 33 && are_few) seen.background.resize(11);
      if (i == 33 && !are_few) seen.background_motion.reset();
      odometry.track(walk.frame(i), seen, {}, {});
    }
    EXPECT_FALSE(odometry.pose());
    EXPECT_EQ(odometry.causal_trajectory().size(), 33u);
  }
}

TEST(RgbdOdometry, TheSameFrameTwiceIsTheSamePlace) {
  const Walk walk(6);
  RgbdOdometry odometry(walk.camera, {}, 1);
  odometry.track(walk.frame(0), walk.see(0), {}, {});
  odometry.track(walk.frame(1), walk.see(0), {}, {});
  const Trajectory trajectory = odometry.trajectory();
  ASSERT_EQ(trajectory.size(), 2u);
  EXPECT_LT(log_se3(relative_pose(trajectory[0].pose, trajectory[1].pose)).norm(), 1e-9);
}

// Points that move otherwise than the rest do not move the camera.
TEST(RgbdOdometry, IgnoresWhatMovesOnItsOwn) {
  const Walk walk(7);
  RgbdOdometry odometry(walk.camera, {}, 1);
  for (int i = 0; i < 20; ++i) {
    TrackedFeatures seen = walk.see(i);
    for (auto& f : seen.background)
      if (f.track % 4 == 0) f.pixel.x() += 1.5 * i;
    odometry.track(walk.frame(i), seen, {}, {});
  }
  const Errors errors = errors_of(walk, odometry.trajectory());
  EXPECT_EQ(errors.poses, 20);
  EXPECT_LT(errors.worst_m, 0.002);
}

}  // namespace
}  // namespace uniquadric
