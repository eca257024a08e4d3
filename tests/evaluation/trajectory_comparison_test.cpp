#include "evaluation/trajectory_comparison.h"

#include <gtest/gtest.h>

#include <numbers>

#include "core/base/files.h"
#include "evaluation/trajectory/evo_steps.h"
#include "tests/evaluation/random_ellipsoid.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {
using std::numbers::pi;
constexpr double kRounding = 1e-9;  // m or rad, of sums over some hundred poses of a few metres
constexpr double kFitted = 1e-7;    // m or rad, of what the iterated calibration leaves
constexpr std::int64_t kTick_ns = 100'000'000;
constexpr double kDegree = pi / 180;

Eigen::Quaterniond yaw(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

// Radius 2 m about the origin, looking along the way, rising with every step.
std::vector<Pose> spiral(int n, double rise_m = 0) {
  std::vector<Pose> poses;
  for (int i = 0; i < n; ++i)
    poses.push_back({yaw(0.1 * i), {2 * std::cos(0.1 * i), 2 * std::sin(0.1 * i), rise_m * i}});
  return poses;
}

std::vector<Pose> random_walk(int n, std::uint64_t seed) {
  RandomStream random(seed, "walk");
  std::vector<Pose> poses = {{random_rotation(random), random_vector(random, 3)}};
  while (static_cast<int>(poses.size()) < n)
    poses.push_back(poses.back() * Pose{exp_so3(random_vector(random, 0.3)), random_vector(random, 0.5)});
  return poses;
}

Trajectory stamped(const std::vector<Pose>& poses, std::int64_t late_ns = 0) {
  Trajectory trajectory;
  for (const Pose& pose : poses)
    trajectory.push_back({static_cast<std::int64_t>(trajectory.size()) * kTick_ns + late_ns, pose});
  return trajectory;
}

template <typename Change>
std::vector<Pose> changed(std::vector<Pose> poses, const Change& change) {
  for (std::size_t i = 0; i < poses.size(); ++i) poses[i] = change(i, poses[i]);
  return poses;
}

PosePairs pairs_of(const std::vector<Pose>& reference, const std::vector<Pose>& estimate) {
  PosePairs pairs{{}, reference, estimate};
  for (std::size_t i = 0; i < reference.size(); ++i)
    pairs.stamps_ns.push_back(static_cast<std::int64_t>(i) * kTick_ns);
  return pairs;
}

class CompareTrajectories : public testing::Test {
 protected:
  std::filesystem::path reference() const { return temp_.path() / "reference.tum"; }
  std::filesystem::path estimate() const { return temp_.path() / "estimate.tum"; }
  TrajectoryComparison compare(const std::vector<Pose>& a, const std::vector<Pose>& b,
                               const TrajectoryOptions& options = {}) const {
    write_tum(reference(), stamped(a));
    write_tum(estimate(), stamped(b));
    return compare_trajectories(reference(), estimate(), options);
  }
  static Statistics figure(const TrajectoryComparison& c, PoseRelation relation, ErrorPart part) {
    for (const ErrorSeries& series : c.errors)
      if (series.relation == relation && series.part == part) return *statistics(series.values);
    ADD_FAILURE() << "no such figure";
    return {};
  }
  static double ape_m(const TrajectoryComparison& c) {
    return figure(c, PoseRelation::ape, ErrorPart::translation).rmse;
  }
  static double rpe_m(const TrajectoryComparison& c) {
    return figure(c, PoseRelation::rpe, ErrorPart::translation).rmse;
  }

 private:
  TempFolder temp_;
};

TrajectoryOptions aligned(AlignmentKind kind) {
  TrajectoryOptions options;
  options.alignment = kind;
  return options;
}

TrajectoryOptions over(double delta, DeltaUnit unit, bool evo = false, bool all_pairs = false) {
  TrajectoryOptions options;
  options.delta = {delta, unit, 0.1, all_pairs};
  options.evo = evo;
  return options;
}
}  // namespace

TEST_F(CompareTrajectories, CircleWithAConstantOffset) {
  const auto circle = spiral(63);
  const auto moved = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation, p.translation + Eigen::Vector3d(0.3, 0.4, 0)};
  });
  const auto plain = compare(circle, moved);
  const Statistics ape = figure(plain, PoseRelation::ape, ErrorPart::translation);
  EXPECT_NEAR(ape.min, 0.5, kRounding);
  EXPECT_NEAR(ape.max, 0.5, kRounding);
  EXPECT_NEAR(ape.sse, 63 * 0.25, kRounding);
  EXPECT_NEAR(ape.std, 0, kRounding);
  EXPECT_EQ(ape.n, 63u);
  EXPECT_NEAR(rpe_m(plain), 0, kRounding);
  EXPECT_EQ(figure(plain, PoseRelation::rpe, ErrorPart::translation).n, 62u);
  for (const auto kind : {AlignmentKind::first, AlignmentKind::se3, AlignmentKind::posyaw})
    EXPECT_NEAR(ape_m(compare(circle, moved, aligned(kind))), 0, kRounding) << to_string(kind);
}

TEST_F(CompareTrajectories, BodyFrameTurnedAgainstTheReferences) {
  const auto circle = spiral(40);
  const auto turned = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation * yaw(0.2), p.translation};
  });
  TrajectoryOptions options;
  options.parts = {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full};
  const auto c = compare(circle, turned, options);
  EXPECT_NEAR(ape_m(c), 0, kRounding);
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::rotation).rmse, 0.2, kRounding);
  // |R - I|_F of a turn by 0.2
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::full).rmse, 2 * std::sqrt(2) * std::sin(0.1),
              kRounding);
  // each step is a chord of 4 sin(0.05) m, seen turned by 0.2
  EXPECT_NEAR(rpe_m(c), 4 * std::sin(0.05) * 2 * std::sin(0.1), kRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::rotation).rmse, 0, kRounding);
}

TEST_F(CompareTrajectories, ScaledTrajectory) {
  const auto circle = spiral(63);  // not quite closed: its mean is off the origin
  const auto half = changed(circle, [](std::size_t, const Pose& p) {
    return Pose{p.rotation, 0.5 * p.translation};
  });
  EXPECT_NEAR(ape_m(compare(circle, half)), 1, kRounding);
  for (const auto kind : {AlignmentKind::sim3, AlignmentKind::scale}) {
    const auto c = compare(circle, half, aligned(kind));
    EXPECT_NEAR(ape_m(c), 0, kRounding);
    EXPECT_NEAR(c.alignment.scale, 2, kRounding);
    EXPECT_NEAR(c.estimate_path_m, c.reference_path_m / 2, kRounding);  // inputs are not changed
  }
  const auto rigid = compare(circle, half, aligned(AlignmentKind::se3));
  EXPECT_NEAR(ape_m(rigid), 1, 0.01);
  EXPECT_EQ(rigid.alignment.scale, 1);
}

TEST_F(CompareTrajectories, YawAlignmentLeavesATilt) {
  const auto way = random_walk(50, 1);
  const Pose turn = {yaw(1.3), {5, -2, 1}};
  const Pose tilt = {Eigen::Quaterniond(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX())),
                     Eigen::Vector3d::Zero()};
  const auto by = [](const Pose& move) { return [move](std::size_t, const Pose& p) { return move * p; }; };
  EXPECT_NEAR(ape_m(compare(way, changed(way, by(turn)), aligned(AlignmentKind::posyaw))), 0, kRounding);
  const auto tilted = compare(way, changed(way, by(tilt * turn)), aligned(AlignmentKind::posyaw));
  EXPECT_GT(ape_m(tilted), 0.01);
  EXPECT_NEAR(figure(tilted, PoseRelation::ape, ErrorPart::rotation).rmse, 0.1, 0.02);
  EXPECT_NEAR(ape_m(compare(way, changed(way, by(tilt * turn)), aligned(AlignmentKind::se3))), 0, kRounding);
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
    EXPECT_NEAR(c.calibrated->max_translation_m, 0, kRounding);
    EXPECT_EQ(c.coverage, 1);
  }
}

TEST_F(CompareTrajectories, WhereTheEstimatesWorldLiesDoesNotMatterAfterAlignment) {
  RandomStream random(3, "worlds");
  const auto way = random_walk(60, 4);
  const auto noisy = changed(way, [&](std::size_t, const Pose& p) {
    return p * Pose{exp_so3(random_vector(random, 0.02)), random_vector(random, 0.05)};
  });
  const Pose move = {random_rotation(random), {30, -20, 10}};
  const auto elsewhere = changed(noisy, [&](std::size_t, const Pose& p) { return move * p; });
  for (const auto kind : {AlignmentKind::first, AlignmentKind::se3, AlignmentKind::sim3}) {
    const auto a = compare(way, noisy, aligned(kind)), b = compare(way, elsewhere, aligned(kind));
    EXPECT_GT(ape_m(a), 0.01);
    for (std::size_t i = 0; i < a.errors.size(); ++i)
      EXPECT_NEAR(statistics(a.errors[i].values)->rmse, statistics(b.errors[i].values)->rmse, kRounding);
  }
  EXPECT_GT(ape_m(compare(way, elsewhere)), 1);
  EXPECT_NEAR(rpe_m(compare(way, elsewhere)), rpe_m(compare(way, noisy)), kRounding);
}

TEST_F(CompareTrajectories, AlignsByTheFirstPairsAlone) {
  const auto way = spiral(60, 0.01);
  const auto late = changed(way, [](std::size_t i, const Pose& p) {
    return i < 30 ? p : Pose{p.rotation, p.translation + Eigen::Vector3d(0, 0, 1)};
  });
  TrajectoryOptions options = aligned(AlignmentKind::se3);
  options.align_pairs = 30;
  const auto c = compare(way, late, options);
  EXPECT_EQ(c.aligned_pairs, 30u);
  EXPECT_NEAR(ape_m(c), std::sqrt(0.5), kRounding);
  EXPECT_LT(ape_m(compare(way, late, aligned(AlignmentKind::se3))), 0.6);
  options.align_pairs = 1000;
  EXPECT_EQ(compare(way, late, options).aligned_pairs, 60u);
}

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
  EXPECT_NEAR(turned(over(1, DeltaUnit::metres)).rmse, 2 * kDegree, kRounding);
  EXPECT_NEAR(turned(over(0.3, DeltaUnit::seconds)).rmse, 3 * kDegree, kRounding);
  EXPECT_NEAR(turned(over(50, DeltaUnit::degrees)).rmse, 5 * kDegree, kRounding);
  EXPECT_EQ(turned(over(50, DeltaUnit::degrees, false, true)).n, 4u);
  // measured on the estimate, 55 degrees are 5 steps and 50 within the tolerance
  TrajectoryOptions options = over(55, DeltaUnit::degrees);
  EXPECT_NEAR(turned(options).rmse, 5 * kDegree, kRounding);  // of 50 and 60, 50 comes first
  options.delta.delta = 66;
  options.pairs_from_reference = false;
  EXPECT_NEAR(turned(options).rmse, 6 * kDegree, kRounding);
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
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::translation).sse, translation, kRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::rotation).sse, rotation, kRounding);
  EXPECT_NEAR(figure(c, PoseRelation::rpe, ErrorPart::full).sse, full, kRounding);
  double ape = 0;
  for (std::size_t i = 0; i < way.size(); ++i)
    ape += (noisy[i].matrix().inverse() * way[i].matrix() - Eigen::Matrix4d::Identity()).squaredNorm();
  EXPECT_NEAR(figure(c, PoseRelation::ape, ErrorPart::full).sse, ape, kRounding);
}

TEST(KittiOdometry, StraightWayLongerByTwoPercentThatBends) {
  std::vector<Pose> straight, bent;
  for (int i = 0; i <= 1000; ++i) {
    straight.push_back({Eigen::Quaterniond::Identity(), {1.0 * i, 0, 0}});
    bent.push_back({yaw(0.01 * kDegree * i), {1.02 * i, 0, 0}});
  }
  const auto turned = *kitti_odometry(pairs_of(straight, changed(straight, [&](std::size_t i, const Pose& p) {
                                                 return Pose{bent[i].rotation, p.translation};
                                               })));
  const auto longer = *kitti_odometry(pairs_of(straight, changed(bent, [](std::size_t, const Pose& p) {
                                                 return Pose{Eigen::Quaterniond::Identity(), p.translation};
                                               })));
  ASSERT_EQ(longer.lengths.size(), 8u);
  double sum_percent = 0, sum_deg = 0;
  std::size_t parts = 0;
  for (std::size_t n = 1; n <= 8; ++n) {
    const double length = 100.0 * static_cast<double>(n),
                 taken = length + 1;  // ends with the first pose past it
    const KittiErrors &errors = longer.lengths[n - 1].errors, &turns = turned.lengths[n - 1].errors;
    EXPECT_EQ(longer.lengths[n - 1].length_m, length);
    EXPECT_EQ(errors.parts, 100 - 10 * n);  // starts 0, 10, ... up to the last that leaves 100 n + 1 m
    EXPECT_NEAR(errors.translation_percent, 2 * taken / length, kRounding);
    EXPECT_NEAR(errors.rotation_deg_per_100m, 0, kRounding);
    EXPECT_NEAR(turns.rotation_deg_per_100m, taken / length, kRounding);
    parts += errors.parts;
    sum_percent += static_cast<double>(errors.parts) * errors.translation_percent;
    sum_deg += static_cast<double>(turns.parts) * turns.rotation_deg_per_100m;
  }
  EXPECT_EQ(longer.mean.parts, parts);
  EXPECT_NEAR(longer.mean.translation_percent, sum_percent / static_cast<double>(parts), kRounding);
  EXPECT_NEAR(turned.mean.rotation_deg_per_100m, sum_deg / static_cast<double>(parts), kRounding);
  straight.resize(100);
  EXPECT_FALSE(kitti_odometry(pairs_of(straight, straight)).has_value());
}

TEST(DriftAngles, AreUnwrappedAndSigned) {
  const std::vector<Pose> still(101, random_walk(1, 7)[0]);
  const auto turning = [&](const Eigen::Vector3d& axis, double angle) {
    return changed(still, [&](std::size_t i, const Pose& p) {
      const double part = static_cast<double>(i) / 100;
      return p * Pose{Eigen::Quaterniond(Eigen::AngleAxisd(angle * part, axis)), Eigen::Vector3d::Zero()};
    });
  };
  const auto z = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitZ(), 400 * kDegree)));
  EXPECT_NEAR(z.yaw.max_rad, 400 * kDegree, kRounding);
  EXPECT_EQ(z.yaw.max_index, 100u);
  EXPECT_NEAR(z.yaw.min_rad, 0, kRounding);
  EXPECT_NEAR(z.roll.max_rad - z.roll.min_rad, 0, kRounding);
  const auto y = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitY(), -150 * kDegree)));
  EXPECT_NEAR(y.pitch.min_rad, -150 * kDegree, 1e-6);  // through the right angle, where the others flip
  EXPECT_EQ(y.pitch.min_index, 100u);
  EXPECT_NEAR(y.yaw.max_rad, 0, 1e-6);
  const auto x = *drift_angles(pairs_of(still, turning(Eigen::Vector3d::UnitX(), -30 * kDegree)));
  EXPECT_NEAR(x.roll.min_rad, -30 * kDegree, kRounding);
  EXPECT_FALSE(drift_angles({}).has_value());
}

TEST(DriftAngles, RollPitchYawAreOfRzRyRx) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-0.2, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  EXPECT_TRUE(roll_pitch_yaw(R).isApprox(Eigen::Vector3d(0.1, -0.2, 0.3), kRounding));
}

TEST(CalibratedDrift, UndoesAnotherFrameOfTheSameBody) {
  RandomStream random(8, "calibration");
  const auto way = random_walk(60, 9);
  const Pose body = {random_rotation(random), random_vector(random, 1)},
             world = {random_rotation(random), {4, 5, 6}};
  const auto other = changed(way, [&](std::size_t, const Pose& p) { return world * p * body; });
  const auto drift = *calibrated_drift(pairs_of(way, other));
  EXPECT_TRUE(drift.determined);
  EXPECT_NEAR(drift.max_translation_m, 0, kFitted);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0, kFitted);
  const PoseError off = absolute_error(body, drift.reference_from_estimate);
  EXPECT_NEAR(off.translation_m, 0, kFitted);
  EXPECT_NEAR(off.rotation_rad, 0, kFitted);
  EXPECT_GT(maximum_drift(pairs_of(way, other))->max_translation_m,
            0.3);  // the form without calibration does not
}

TEST(CalibratedDrift, FitsAllOfALongWayThoughItStartsFromAPart) {
  const auto way = random_walk(1200, 12);
  RandomStream random(13, "body");
  const Pose body = {random_rotation(random), random_vector(random, 1)};
  auto other = changed(way, [&](std::size_t, const Pose& p) { return p * body; });
  other[700] = other[700] * Pose{yaw(0.3), {0.2, 0, 0}};  // not among every third
  const auto drift = *calibrated_drift(pairs_of(way, other));
  EXPECT_EQ(drift.angle_index, 700u);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0.3, 0.02);
  EXPECT_NEAR(absolute_error(body, drift.reference_from_estimate).rotation_rad, 0, 0.01);
}

TEST(CalibratedDrift, SaysWhatTheMotionLeavesOpen) {
  const auto flat = spiral(40);  // turns about z alone: C's z is free
  const Pose body = {yaw(0.7), {0.3, -0.2, 0.5}};
  const auto drift =
      *calibrated_drift(pairs_of(flat, changed(flat, [&](std::size_t, const Pose& p) { return p * body; })));
  EXPECT_FALSE(drift.determined);
  EXPECT_NEAR(drift.max_translation_m, 0, kFitted);
}

TEST(CalibratedDrift, IsALeastSquaresFitAndFindsALateJump) {
  RandomStream random(10, "jump");
  const auto way = random_walk(60, 11);
  const auto noisy = changed(way, [&](std::size_t, const Pose& p) {
    return p * Pose{exp_so3(random_vector(random, 0.01)), random_vector(random, 0.01)};
  });
  const auto pairs = pairs_of(way, noisy);
  const auto cost = [&](const Pose& C) {
    double sum = 0;
    for (std::size_t k = 1; k < way.size(); ++k) {
      const Eigen::Matrix4d e = noisy[k].matrix().inverse() * noisy[0].matrix();
      const Eigen::Matrix4d g = way[k].matrix().inverse() * way[0].matrix();
      const Eigen::Matrix4d E = C.matrix() * e * C.matrix().inverse() * g.inverse();
      sum += log_se3({Eigen::Quaterniond(Eigen::Matrix3d(E.topLeftCorner<3, 3>())), E.block<3, 1>(0, 3)})
                 .squaredNorm();
    }
    return sum;
  };
  const Pose best = calibrated_drift(pairs)->reference_from_estimate;
  for (int i = 0; i < 6; ++i)
    for (const double step : {-1e-3, 1e-3}) {
      Vector6d twist = Vector6d::Zero();
      twist[i] = step;
      EXPECT_GT(cost(exp_se3(twist) * best), cost(best)) << i;
    }
  auto jumped = way;
  jumped.back() = jumped.back() * Pose{yaw(0.2), {0.3, 0, 0}};
  const auto drift = *calibrated_drift(pairs_of(way, jumped));
  EXPECT_EQ(drift.translation_index, way.size() - 1);
  EXPECT_EQ(drift.angle_index, way.size() - 1);
  EXPECT_NEAR(drift.max_translation_m, 0.3, 0.05);
  EXPECT_NEAR(drift.roll_pitch_yaw_rad.norm(), 0.2, 0.05);
  EXPECT_FALSE(calibrated_drift(pairs_of({way[0], way[1]}, {way[0], way[1]})).has_value());
}

TEST(ParseDelta, TakesANumberAndItsUnit) {
  EXPECT_EQ(parse_delta("1f")->unit, DeltaUnit::frames);
  EXPECT_EQ(parse_delta("2.5m")->value, 2.5);
  EXPECT_EQ(parse_delta("1s")->unit, DeltaUnit::seconds);
  EXPECT_EQ(parse_delta("10deg")->unit, DeltaUnit::degrees);
  for (const char* bad : {"", "1", "f", "1.5f", "0m", "-1s", "nanm", "1 m", "1rad", "1km"})
    EXPECT_FALSE(parse_delta(bad).has_value()) << bad;
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
    EXPECT_NE(refusal(aligned(kind)).find("estimate.tum: alignment: the positions lie on a line"),
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
