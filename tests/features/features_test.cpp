#include "estimator/features/features.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <set>

#include "drawn_world.h"

namespace uniquadric {
namespace {

constexpr double kRate_hz = 30;

SequenceFrame frame_at(int i) {
  SequenceFrame frame;
  frame.frame = i;
  frame.stamp_ns = std::int64_t(i * 1e9 / kRate_hz);
  return frame;
}

// A box that tumbles before a wall, both seen by a camera that moves.
struct TumblingBox {
  std::vector<DrawnCard> box = box_cards(3, {0.5, 0.4, 0.3}, 11);
  DrawnCard wall{0, {6, 5}, block_texture(900, 5), {}};

  Pose world_from_camera(int i) const { return {exp_so3({0, 0.004 * i, 0.001 * i}), {0.01 * i, 0, 0}}; }
  Pose world_from_box(int i) const {
    return {exp_so3({0.5 + 0.02 * i, 0.6 - 0.025 * i, 0.1}), {0.1 + 0.008 * i, 0.02, 1.5 - 0.006 * i}};
  }
  Pose camera_from_box(int i) const { return relative_pose(world_from_camera(i), world_from_box(i)); }
  Pose camera_from_wall(int i) const {
    return relative_pose(world_from_camera(i), {exp_so3({0.1, 0.15, 0}), {0, 0, 2.8}});
  }
  DrawnFrame frame(int i, const DrawnNoise& noise) const {
    auto cards = moved(box, camera_from_box(i));
    cards.push_back(wall);
    cards.back().camera_from_card = camera_from_wall(i);
    return draw(small_camera(), cards, noise, i);
  }
};

TrackedFeatures track(FeatureTracker& tracker, int i, const DrawnFrame& frame) {
  return tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks);
}

// Whose surroundings within the tracker's window, 15 px, show more than its body.
TEST(Features, ThoseAboutTheOutlineAreSaidToBe) {
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), {}, 1);
  const auto frame = world.frame(0, {0.005, 2});
  int rim = 0, inner = 0;
  for (const Feature& feature : track(tracker, 0, frame).bodies.at(3)) {
    const int u = static_cast<int>(std::lround(feature.pixel.x())),
              v = static_cast<int>(std::lround(feature.pixel.y()));
    bool shows_other = false;
    for (int dv = -7; dv <= 7; ++dv)
      for (int du = -7; du <= 7; ++du) shows_other |= frame.masks.at<std::uint16_t>(v + dv, u + du) != 3;
    EXPECT_EQ(feature.rim, shows_other) << u << ' ' << v;
    ++(shows_other ? rim : inner);
  }
  EXPECT_GT(rim, 5);
  EXPECT_GT(inner, 5);
}

TEST(Features, MotionsOfABoxAndOfTheCameraAreRight) {
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), {}, 1);
  double worst_turn = 0, worst_shift = 0;
  int counted = 0;
  for (int i = 0; i < 12; ++i) {
    const auto frame = world.frame(i, {0.005, 2});
    const auto seen = track(tracker, i, frame);
    EXPECT_GT(seen.background.size(), 60u);
    ASSERT_TRUE(seen.bodies.contains(3));
    EXPECT_GT(seen.bodies.at(3).size(), 30u);
    if (i == 0) {
      EXPECT_TRUE(seen.motions.empty());
      EXPECT_FALSE(seen.background_motion);
      continue;
    }
    ASSERT_TRUE(seen.motions.contains(3));
    const Pose truth = world.camera_from_box(i) * world.camera_from_box(i - 1).inverse();
    const Pose centre{Eigen::Quaterniond::Identity(), world.camera_from_box(i).translation};
    const Pose error = centre.inverse() * (seen.motions.at(3) * truth.inverse()) * centre;
    worst_shift = std::max(worst_shift, error.translation.norm());
    worst_turn = std::max(worst_turn, log_so3(error.rotation).norm());
    ++counted;
    ASSERT_TRUE(seen.background_motion);
    const Pose camera_truth = world.camera_from_wall(i) * world.camera_from_wall(i - 1).inverse();
    EXPECT_LT(log_so3(seen.background_motion->rotation * camera_truth.rotation.conjugate()).norm(), 0.004);
  }
  EXPECT_EQ(counted, 11);
  EXPECT_LT(worst_shift, 0.004);
  EXPECT_LT(worst_turn, 0.01);
}

// Every sighting of a track is of one point of its body, and the pixel is where that point is.
TEST(Features, TracksStayOnTheirPoints) {
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), {}, 1);
  std::map<std::int64_t, Eigen::Vector3d> points;
  double sum = 0;
  int count = 0;
  std::set<std::int64_t> background_ids;
  for (int i = 0; i < 12; ++i) {
    const auto frame = world.frame(i, {0.005, 2});
    const auto seen = track(tracker, i, frame);
    for (const auto& feature : seen.background) background_ids.insert(feature.track);
    for (const auto& feature : seen.bodies.at(3)) {
      const int u = int(std::lround(feature.pixel.x())), v = int(std::lround(feature.pixel.y()));
      ASSERT_EQ(frame.masks.at<std::uint16_t>(v, u), 3);
      EXPECT_FALSE(background_ids.contains(feature.track));
      if (!points.contains(feature.track)) {
        const Eigen::Vector3d ray = *small_camera().unproject(feature.pixel);
        points[feature.track] =
            world.camera_from_box(i).inverse() * (double(frame.true_depth.at<float>(v, u)) * ray);
        continue;
      }
      const auto expected = small_camera().project(world.camera_from_box(i) * points[feature.track]);
      sum += (*expected - feature.pixel).squaredNorm();
      ++count;
    }
  }
  EXPECT_GT(count, 300);
  EXPECT_LT(std::sqrt(sum / count), 0.8);
}

TEST(Features, AnEnvelopeTakesFeaturesOff) {
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), {}, 1);
  const auto frame = world.frame(0, {});
  int asked = 0;
  const auto seen = tracker.track(frame_at(0), frame.gray, frame.depth, frame.masks,
                                  {{3, {std::nullopt, [&](const Eigen::Vector3d& p) {
                                          ++asked;
                                          return p.x() > 0.1;
                                        }}}});
  EXPECT_GT(asked, 20);
  ASSERT_TRUE(seen.bodies.contains(3));
  for (const auto& feature : seen.bodies.at(3))
    EXPECT_GT((small_camera().unproject(feature.pixel)->x() * feature.depth_m), 0.1);
}

// A hint that says what the tracker expects by itself changes no bit.
TEST(Features, AHintOfTheLastMotionIsTheTrackersOwn) {
  const TumblingBox world;
  FeatureTracker alone(small_camera(), {}, 1), told(small_camera(), {}, 1);
  std::optional<Pose> motion;
  int hints = 0;
  for (int i = 0; i < 8; ++i) {
    const auto frame = world.frame(i, {0.005, 2});
    const auto step_ns = [&](int k) { return double(frame_at(k).stamp_ns - frame_at(k - 1).stamp_ns); };
    BodyHints hint;
    if (motion) hint[3].motion = exp_se3(step_ns(i) / step_ns(i - 1) * log_se3(*motion));
    hints += static_cast<int>(hint.size());
    const auto a = track(alone, i, frame);
    const auto b = told.track(frame_at(i), frame.gray, frame.depth, frame.masks, hint);
    ASSERT_EQ(a.motions.contains(3), b.motions.contains(3));
    motion.reset();
    if (a.motions.contains(3)) motion = a.motions.at(3);
    ASSERT_EQ(a.bodies.at(3).size(), b.bodies.at(3).size()) << i;
    for (std::size_t k = 0; k < a.bodies.at(3).size(); ++k)
      EXPECT_EQ(a.bodies.at(3)[k].pixel, b.bodies.at(3)[k].pixel);
  }
  EXPECT_EQ(hints, 6);
}

// The box leaps by a fifth of a metre from one frame to the next: who is told finds points of it there.
TEST(Features, AHintLeadsOverALeap) {
  constexpr int kLeap = 4;
  const Pose leap{Eigen::Quaterniond::Identity(), {0.2, 0, 0}};
  const auto kept = [&](bool is_told) {
    TumblingBox world;
    FeatureOptions options;
    options.gallery.body_tracks = 0;  // nothing that was lost is recognised
    FeatureTracker tracker(small_camera(), options, 1);
    std::set<std::int64_t> before, after;
    for (int i = 0; i <= kLeap; ++i) {
      if (i == kLeap)
        for (DrawnCard& card : world.box) card.camera_from_card = leap * card.camera_from_card;
      const auto frame = world.frame(i, {0.005, 2});
      BodyHints hint;
      if (i == kLeap && is_told)
        hint[3].motion = world.camera_from_box(i) * leap * world.camera_from_box(i - 1).inverse();
      const auto seen = tracker.track(frame_at(i), frame.gray, frame.depth, frame.masks, hint);
      auto& ids = i == kLeap ? after : before;
      if (i >= kLeap - 1)
        for (const auto& feature : seen.bodies.at(3)) ids.insert(feature.track);
    }
    return std::count_if(after.begin(), after.end(), [&](auto id) { return before.contains(id); });
  };
  EXPECT_GT(kept(true), 10);
  EXPECT_LT(kept(false), 5);
}

TEST(Features, PoorInputGivesNoMotionAndNoCrash) {
  const cv::Size size(320, 240);
  const cv::Mat black = cv::Mat::zeros(size, CV_8UC1), no_depth = cv::Mat::zeros(size, CV_32FC1);
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), {}, 1);
  const auto good = world.frame(0, {});
  EXPECT_TRUE(tracker.track(frame_at(0), black, good.depth, good.masks).background.empty());
  EXPECT_FALSE(track(tracker, 1, good).background_motion);
  EXPECT_TRUE(tracker.track(frame_at(2), black, good.depth, good.masks).motions.empty());
  EXPECT_TRUE(track(tracker, 3, good).motions.empty());
  const auto same = track(tracker, 4, good);  // the same image again: at rest
  ASSERT_TRUE(same.background_motion);
  EXPECT_LT(log_se3(*same.background_motion).norm(), 1e-3);
  FeatureTracker blind(small_camera(), {}, 1);
  for (int i = 0; i < 3; ++i) {
    const auto frame = world.frame(i, {});
    const auto seen = blind.track(frame_at(i), frame.gray, no_depth, frame.masks);
    EXPECT_FALSE(seen.background_motion);
    EXPECT_TRUE(seen.motions.empty());
  }
  FeatureTracker unmasked(small_camera(), {}, 1);
  EXPECT_TRUE(unmasked.track(frame_at(0), good.gray, {}, {}).bodies.empty());
}

// Frames whose depth is refused, of twelve; `scale`: of the depth of a frame.
// `changed`: the frame where all that was mapped has the wrong scale.
std::set<int> refused_frames(const std::function<double(int)>& scale, int changed = 0,
                             const FeatureOptions& options = {}) {
  const TumblingBox world;
  FeatureTracker tracker(small_camera(), options, 1);
  std::set<int> refused;
  for (int i = 0; i < 12; ++i) {
    DrawnFrame frame = world.frame(i, {0.005, 2});
    frame.depth = frame.depth * scale(i);
    const auto seen = track(tracker, i, frame);
    if (seen.depth_refused) refused.insert(i);
    for (const auto* features : {&seen.background, &seen.bodies.at(3)}) {
      const auto with_depth = std::count_if(features->begin(), features->end(),
                                            [](const Feature& feature) { return feature.depth_m > 0; });
      EXPECT_GE(with_depth, seen.depth_refused ? 0 : 30) << i;
      EXPECT_LE(with_depth, seen.depth_refused ? 0 : std::ssize(*features)) << i;
    }
    if (i == 0) continue;
    EXPECT_EQ(seen.depth_changed, i == changed) << i;
    EXPECT_TRUE(seen.background_motion) << i;
    const Pose truth = world.camera_from_wall(i) * world.camera_from_wall(i - 1).inverse();
    const Eigen::Vector3d shift = seen.background_motion.value_or(Pose{}).translation;
    EXPECT_LT((shift - truth.translation).norm(), 0.01) << i;  // where 4 % of the wall's depth are 0.11
  }
  return refused;
}

TEST(Features, DepthOfAnotherScaleForAWhileIsRefused) {
  EXPECT_EQ(refused_frames([](int) { return 1; }), std::set<int>{});
  EXPECT_EQ(refused_frames([](int i) { return 1 + 0.001 * i; }), std::set<int>{});
  EXPECT_EQ(refused_frames([](int i) { return i == 7 ? 0.96 : 1; }), std::set<int>{7});
  EXPECT_EQ(refused_frames([](int i) { return i >= 5 && i < 8 ? 1.04 : 1; }), (std::set<int>{5, 6, 7}));
}

// The map is of the first frame; four are believed after it until the scale changes.
TEST(Features, DepthOfAnotherScaleThatStaysIsBelieved) {
  EXPECT_EQ(refused_frames([](int i) { return i == 0 ? 1.04 : 1; }, 1), std::set<int>{});
  EXPECT_EQ(refused_frames([](int i) { return i >= 5 ? 1.04 : 1; }, 9), (std::set<int>{5, 6, 7, 8}));
  FeatureOptions hasty;
  hasty.max_scale_refused_s = 0.05;  // a frame and a half
  EXPECT_EQ(refused_frames([](int i) { return i >= 5 ? 1.04 : 1; }, 7, hasty), (std::set<int>{5, 6}));
}

}  // namespace
}  // namespace uniquadric
