#include <gtest/gtest.h>

#include "evaluation/trajectory/evo_steps.h"
#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {

TEST_F(CompareTrajectories, StepsInMetresSecondsAndDegrees) {
  std::vector<Pose> line, longer;
  for (int i = 0; i < 9; ++i) {
    line.push_back({yaw(10 * kDegree * i), {0.5 * i, 0, 0}});
    longer.push_back({yaw(11 * kDegree * i), {0.55 * i, 0, 0}});
  }
  const auto turned = [&](const TrajectoryOptions& options) {
    return figure(compare(line, longer, options), PoseRelation::rpe, ErrorPart::rotation);
  };
  EXPECT_EQ(turned(over(1, DeltaUnit::metres)).n, 4u);
  EXPECT_NEAR(turned(over(1, DeltaUnit::metres)).rmse, 2 * kDegree, kPoseRounding);
  EXPECT_NEAR(turned(over(0.3, DeltaUnit::seconds)).rmse, 3 * kDegree, kPoseRounding);
  EXPECT_NEAR(turned(over(50, DeltaUnit::degrees)).rmse, 5 * kDegree, kPoseRounding);
  EXPECT_EQ(turned(over(50, DeltaUnit::degrees, false, true)).n, 4u);
  // measured on the estimate, 55 degrees are 5 steps and 50 within the tolerance
  TrajectoryOptions options = over(55, DeltaUnit::degrees);
  EXPECT_NEAR(turned(options).rmse, 5 * kDegree, kPoseRounding);  // of 50 and 60, 50 comes first
  options.delta.delta = 66;
  options.pairs_from_reference = false;
  EXPECT_NEAR(turned(options).rmse, 6 * kDegree, kPoseRounding);
}

TEST_F(CompareTrajectories, NoStepIsLongerThanTheTrajectory) {
  const auto way = random_walk(9, 2);
  const std::vector<std::int64_t> stamps_ns(way.size());
  for (const bool all_pairs : {false, true}) {
    EXPECT_EQ(delta_steps(way, stamps_ns, {8, DeltaUnit::frames, 0.1, all_pairs}).size(), 1u);
    for (const double frames : {9., 0x1p63, 0x1p64, 1e30, 1e300}) {  // no index holds 2^64 and more
      EXPECT_TRUE(delta_steps(way, stamps_ns, {frames, DeltaUnit::frames, 0.1, all_pairs}).empty()) << frames;
      EXPECT_TRUE(evo_steps(way, {frames, DeltaUnit::frames, 0.1, all_pairs}).empty()) << frames;
    }
  }
}

TEST(EvoSteps, DifferFromOursAsEvoDoes) {
  std::vector<Pose> poses;
  for (int i = 0; i < 9; ++i) poses.push_back({yaw(10 * kDegree * i), {0.5 * i, 0, 0}});
  using Steps = std::vector<IndexStep>;
  // the first step starts where the path first reaches delta; a step may be longer than delta
  EXPECT_EQ(evo_steps(poses, {1, DeltaUnit::metres, 0.1, false}), (Steps{{2, 4}, {4, 6}, {6, 8}}));
  EXPECT_EQ(evo_steps(poses, {1.2, DeltaUnit::metres, 0.1, false}), (Steps{{3, 6}}));
  EXPECT_EQ(evo_steps(poses, {3, DeltaUnit::metres, 0.1, true}), (Steps{{0, 6}, {1, 7}, {2, 8}}));
  EXPECT_EQ(evo_steps(poses, {29.9, DeltaUnit::degrees, 0.1, false}), (Steps{{0, 3}, {3, 6}}));
  // with all pairs every pose in the band, not the nearest alone: 63 +- 6.3 takes in 60 alone, 66 +- 6.6 both
  EXPECT_EQ(evo_steps(poses, {63, DeltaUnit::degrees, 0.1, true}), (Steps{{0, 6}, {1, 7}, {2, 8}}));
  EXPECT_EQ(evo_steps(poses, {66, DeltaUnit::degrees, 0.1, true}),
            (Steps{{0, 6}, {0, 7}, {1, 7}, {1, 8}, {2, 8}}));
  EXPECT_EQ(evo_steps(poses, {3, DeltaUnit::frames, 0.1, false}), (Steps{{0, 3}, {3, 6}}));
  // angles end at 180 degrees, the band may not; -q is the turn of q
  std::vector<Pose> opposite = {{yaw(0), Eigen::Vector3d::Zero()},
                                {yaw(179 * kDegree), Eigen::Vector3d::Zero()}};
  EXPECT_EQ(evo_steps(opposite, {180, DeltaUnit::degrees, 0.1, true}), (Steps{{0, 1}}));
  opposite[1].rotation.coeffs() *= -1;
  EXPECT_EQ(evo_steps(opposite, {180, DeltaUnit::degrees, 0.1, true}), (Steps{{0, 1}}));
  EXPECT_EQ(evo_steps(opposite, {100, DeltaUnit::degrees, 0.1, true}), Steps{});
  EXPECT_EQ(evo_steps(poses, {6, DeltaUnit::frames, 0.1, true}), (Steps{{0, 6}, {1, 7}, {2, 8}}));
  EXPECT_NE(input_error([&] {
              evo_steps(poses, {1, DeltaUnit::seconds, 0.1, false});
            }).find("seconds"),
            std::string::npos);
}

// evo's definitions over again with 4x4 matrices.
TEST_F(CompareTrajectories, EvosFiguresASecondWay) {
  RandomStream random(5, "evo");
  const auto way = random_walk(80, 6);
  const auto noisy = changed(way, [&](std::size_t, const Pose& p) {
    return p * Pose{exp_so3(random_vector(random, 0.1)), random_vector(random, 0.1)};
  });
  TrajectoryOptions options = over(1.5, DeltaUnit::metres, true);
  options.parts = {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full};
  const auto c = compare(way, noisy, options);
  std::vector<std::size_t> ends;
  double path_m = 0;
  for (std::size_t i = 1; i < noisy.size(); ++i) {  // on the estimate's poses
    path_m += (noisy[i].matrix() - noisy[i - 1].matrix()).col(3).norm();
    if (path_m >= 1.5) ends.push_back(i), path_m = 0;
  }
  double translation = 0, rotation = 0, full = 0;
  for (std::size_t k = 1; k < ends.size(); ++k) {
    const auto motion = [&](const std::vector<Pose>& poses) -> Eigen::Matrix4d {
      return poses[ends[k - 1]].matrix().inverse() * poses[ends[k]].matrix();
    };
    const Eigen::Matrix4d E = motion(way).inverse() * motion(noisy);
    translation += E.block<3, 1>(0, 3).squaredNorm();
    rotation += std::pow(Eigen::AngleAxisd(Eigen::Matrix3d(E.topLeftCorner<3, 3>())).angle(), 2);
    full += (E - Eigen::Matrix4d::Identity()).squaredNorm();
  }
  ASSERT_GT(ends.size(), 10u);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::translation).sse, translation, kPoseRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::rotation).sse, rotation, kPoseRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::full).sse, full, kPoseRounding);
  double ape = 0;
  for (std::size_t i = 0; i < way.size(); ++i)
    ape += (noisy[i].matrix().inverse() * way[i].matrix() - Eigen::Matrix4d::Identity()).squaredNorm();
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::full).sse, ape, kPoseRounding);
}

TEST(ParseDelta, TakesANumberAndItsUnit) {
  EXPECT_EQ(parse_delta("1f")->unit, DeltaUnit::frames);
  EXPECT_EQ(parse_delta("2.5m")->value, 2.5);
  EXPECT_EQ(parse_delta("1s")->unit, DeltaUnit::seconds);
  EXPECT_EQ(parse_delta("10deg")->unit, DeltaUnit::degrees);
  for (const char* bad : {"", "1", "f", "1.5f", "0m", "-1s", "nanm", "1 m", "1rad", "1km"})
    EXPECT_FALSE(parse_delta(bad).has_value()) << bad;
}

}  // namespace uniquadric
