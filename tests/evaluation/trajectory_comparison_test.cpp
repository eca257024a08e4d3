#include "evaluation/trajectory_comparison.h"

#include <gtest/gtest.h>

#include "core/base/files.h"
#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {

TEST_F(CompareTrajectories, CircleWithAConstantOffset) {
  const auto circle = spiral(63);
  const auto moved = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation, p.translation + Eigen::Vector3d(0.3, 0.4, 0)};
  });
  const auto plain = compare(circle, moved);
  const Statistics ape = figure(plain, PoseRelation::ape, ErrorPart::translation);
  EXPECT_NEAR(ape.min, 0.5, kPoseRounding);
  EXPECT_NEAR(ape.max, 0.5, kPoseRounding);
  EXPECT_NEAR(ape.sse, 63 * 0.25, kPoseRounding);
  EXPECT_NEAR(ape.std, 0, kPoseRounding);
  EXPECT_EQ(ape.n, 63u);
  EXPECT_NEAR(rpe_m(plain), 0, kPoseRounding);
  EXPECT_EQ(figure(plain, PoseRelation::rpe, ErrorPart::translation).n, 62u);
  for (const auto kind : {AlignmentKind::first, AlignmentKind::se3, AlignmentKind::posyaw})
    EXPECT_NEAR(ape_m(compare(circle, moved, aligned(kind))), 0, kPoseRounding) << to_string(kind);
}

TEST_F(CompareTrajectories, BodyFrameTurnedAgainstTheReferences) {
  const auto circle = spiral(40);
  const auto turned = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation * yaw(0.2), p.translation};
  });
  TrajectoryOptions options;
  options.parts = {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full};
  const auto c = compare(circle, turned, options);
  EXPECT_NEAR(ape_m(c), 0, kPoseRounding);
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::rotation).rmse, 0.2, kPoseRounding);
  // |R - I|_F of a turn by 0.2
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::full).rmse, 2 * std::sqrt(2) * std::sin(0.1),
              kPoseRounding);
  // each step is a chord of 4 sin(0.05) m, seen turned by 0.2
  EXPECT_NEAR(rpe_m(c), 4 * std::sin(0.05) * 2 * std::sin(0.1), kPoseRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::rotation).rmse, 0, kPoseRounding);
}

TEST_F(CompareTrajectories, IdenticalTrajectoriesHaveNoErrorAtAll) {
  const auto way = random_walk(60, 2);
  TrajectoryOptions options;
  options.parts = {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full};
  options.drift = true;
  for (const auto kind : {AlignmentKind::none, AlignmentKind::first, AlignmentKind::se3, AlignmentKind::sim3,
                          AlignmentKind::scale, AlignmentKind::posyaw, AlignmentKind::poses}) {
    options.alignment = kind;
    const auto c = compare(way, way, options);
    EXPECT_EQ(c.errors.size(), 6u);
    for (const ErrorSeries& series : c.errors) EXPECT_EQ(statistics(series.values)->max, 0);
    EXPECT_EQ(c.drift->max_translation_m, 0);
    EXPECT_NEAR(c.calibrated->max_translation_m, 0, kPoseRounding);
    EXPECT_EQ(c.coverage, 1);
  }
}

TEST_F(CompareTrajectories, PairsByTimeAndSaysHowManyThereAre) {
  const auto way = spiral(40);
  write_tum(reference(), stamped(way));
  Trajectory every_second;
  for (std::size_t i = 0; i < way.size(); i += 2) every_second.push_back(stamped(way, 4'000'000)[i]);
  write_tum(estimate(), every_second);
  EXPECT_EQ(compare_trajectories(reference(), estimate(), {}).coverage, 0.5);
  TrajectoryOptions options;
  options.association.max_difference_ns = 3'000'000;
  EXPECT_NE(
      input_error([&] {
        compare_trajectories(reference(), estimate(), options);
      }).find("estimate.tum: 0 of 20 poses lie within 0.003 s of the reference's 40, at least 3 are needed"),
      std::string::npos);
}

TEST_F(CompareTrajectories, RefusesWhatLeavesTheAlignmentOpenOrHasNoSteps) {
  std::vector<Pose> line;
  for (int i = 0; i < 5; ++i) line.push_back({yaw(0), {1.0 * i, 0, 0}});
  const auto refusal = [&](const TrajectoryOptions& options) {
    return input_error([&] { compare(line, line, options); });
  };
  for (const auto kind : {AlignmentKind::se3, AlignmentKind::sim3, AlignmentKind::scale})
    EXPECT_NE(refusal(aligned(kind))
                  .find(std::string("estimate.tum: alignment ") + to_string(kind) +
                        ": the 5 positions lie on a line"),
              std::string::npos);
  TrajectoryOptions options = aligned(AlignmentKind::posyaw);
  options.align_pairs = 2;
  EXPECT_NE(refusal(options).find("needs at least 3 pairs"), std::string::npos);
  EXPECT_NE(refusal(over(10, DeltaUnit::metres)).find("delta 10m: no two of the 5 pairs"), std::string::npos);
  write_text(estimate(), "# nothing\n");
  EXPECT_NE(input_error([&] { compare_trajectories(reference(), estimate(), {}); }).find("has no poses"),
            std::string::npos);
  write_text(estimate(), "0 0 0 0 0 0 0 1\n0.1 0 0 x 0 0 0 1\n");
  EXPECT_NE(input_error([&] {
              compare_trajectories(reference(), estimate(), {});
            }).find("estimate.tum:2: 'x' is not a finite number"),
            std::string::npos);
}

}  // namespace uniquadric
