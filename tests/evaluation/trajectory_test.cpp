#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numbers>

#include "core/base/error.h"
#include "core/base/hungarian.h"
#include "core/geometry/box_symmetry.h"
#include "evaluation/align/alignment.h"
#include "evaluation/align/symmetry.h"
#include "evaluation/association/stamps.h"
#include "evaluation/statistics/statistics.h"
#include "evaluation/trajectory/trajectory_error.h"
#include "tests/evaluation/random_ellipsoid.h"

namespace uniquadric {
namespace {
using std::numbers::pi;
constexpr double kRounding = 1e-12;  // m or rad, of a few products of unit size

std::vector<Pose> random_poses(int n, std::uint64_t seed) {
  RandomStream random(seed, "poses");
  std::vector<Pose> poses;
  for (int i = 0; i < n; ++i) {
    const Eigen::Quaterniond q = random_rotation(random);
    poses.push_back({q, random_vector(random, 2)});
  }
  return poses;
}

Pose turn_z(double angle) {
  return {Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ())), Eigen::Vector3d::Zero()};
}

Ellipsoid body(const Eigen::Quaterniond& q, const Eigen::Vector3d& a) {
  return {{q, Eigen::Vector3d(1, 2, 3)}, a};
}
}  // namespace

TEST(Statistics, HandWorkedExample) {
  const auto s = *statistics({3, 1, 2, 6});
  EXPECT_EQ(s.n, 4u);
  EXPECT_DOUBLE_EQ(s.mean, 3);
  EXPECT_DOUBLE_EQ(s.median, 2.5);
  EXPECT_DOUBLE_EQ(s.sse, 50);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(s.std, std::sqrt(3.5));
  EXPECT_EQ(s.min, 1);
  EXPECT_EQ(s.max, 6);
  EXPECT_FALSE(statistics({}).has_value());
}

TEST(PoseError, RotationAngleHasNoBlindSpots) {
  int cases = 0;
  for (const double angle : {0.0, 1e-12, 1e-6, 0.5, pi / 2, 3.0, pi - 1e-9, pi}) {
    const PoseError error = absolute_error(turn_z(0.3), turn_z(0.3 + angle));
    EXPECT_NEAR(error.rotation_rad, angle, kRounding);
    ++cases;
  }
  EXPECT_EQ(cases, 8);
}

TEST(PoseError, RelativeErrorIgnoresTheWorldAndMotionErrorTheBody) {
  const auto p = random_poses(6, 1);
  const PoseError plain = relative_error(p[0], p[1], p[2], p[3]);
  const PoseError moved = relative_error(p[0], p[1], p[4] * p[2], p[4] * p[3]);
  EXPECT_NEAR(plain.translation_m, moved.translation_m, kRounding);
  EXPECT_NEAR(plain.rotation_rad, moved.rotation_rad, kRounding);
  // another body frame: same motion error, and none where the motion is the true one
  const PoseError motion = object_motion_error(p[0], p[1], p[2], p[3]);
  const PoseError other_body = object_motion_error(p[0], p[1], p[2] * p[5], p[3] * p[5]);
  EXPECT_NEAR(motion.translation_m, other_body.translation_m, kRounding);
  EXPECT_NEAR(motion.rotation_rad, other_body.rotation_rad, kRounding);
  EXPECT_NEAR(object_motion_error(p[0], p[1], p[0] * p[5], p[1] * p[5]).translation_m, 0, kRounding);
  EXPECT_GT(relative_error(p[0], p[1], p[0] * p[5], p[1] * p[5]).translation_m, 0.1);
  // relative error of a known error on the right
  const Pose error = {turn_z(0.25).rotation, Eigen::Vector3d(3, 4, 0)};
  const PoseError known = relative_error(p[0], p[1], p[0], p[1] * error);
  EXPECT_NEAR(known.translation_m, 5, kRounding);
  EXPECT_NEAR(known.rotation_rad, 0.25, kRounding);
}

TEST(Drift, IsMeasuredAfterAligningTheFirstPose) {
  PosePairs poses;
  const Pose offset = random_poses(1, 2)[0];
  for (int i = 0; i < 5; ++i) {
    poses.stamps_ns.push_back(i);
    poses.reference.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(i, 0, 0)});
    poses.estimate.push_back(offset * Pose{turn_z(0.01 * i).rotation, Eigen::Vector3d(i, 0.1 * i, 0)});
  }
  const auto drift = maximum_drift(poses);
  EXPECT_NEAR(drift->max_translation_m, 0.4, kRounding);
  EXPECT_NEAR(*drift->max_translation_percent_of_path, 10, 1e-10);
  EXPECT_NEAR(drift->max_angle_rad, 0.04, kRounding);
}

TEST(DeltaSteps, FramesMetresSecondsDegrees) {
  std::vector<Pose> poses;
  std::vector<std::int64_t> stamps;
  for (int i = 0; i < 7; ++i) {
    poses.push_back({turn_z(i * 10 * pi / 180).rotation, Eigen::Vector3d(0.5 * i, 0, 0)});
    stamps.push_back(i * 100'000'000);
  }
  using Steps = std::vector<IndexStep>;
  EXPECT_EQ(delta_steps(poses, stamps, {3, DeltaUnit::frames, 0.1, false}), (Steps{{0, 3}, {3, 6}}));
  EXPECT_EQ(delta_steps(poses, stamps, {4, DeltaUnit::frames, 0.1, true}), (Steps{{0, 4}, {1, 5}, {2, 6}}));
  EXPECT_EQ(delta_steps(poses, stamps, {1, DeltaUnit::metres, 0.1, false}), (Steps{{0, 2}, {2, 4}, {4, 6}}));
  EXPECT_EQ(delta_steps(poses, stamps, {0.3, DeltaUnit::seconds, 0.1, false}), (Steps{{0, 3}, {3, 6}}));
  EXPECT_EQ(delta_steps(poses, stamps, {50, DeltaUnit::degrees, 0.1, true}), (Steps{{0, 5}, {1, 6}}));
  EXPECT_EQ(delta_steps(poses, stamps, {0.75, DeltaUnit::metres, 0.1, true}), Steps{});
  EXPECT_THROW(delta_steps(poses, stamps, {0, DeltaUnit::metres, 0.1, true}), InputError);
}

TEST(Stamps, NearestIsInclusiveAndOneToOneTakesEachOnce) {
  constexpr std::int64_t ms = 1'000'000;
  const std::vector<std::int64_t> reference = {0, 100 * ms, 200 * ms, 300 * ms},
                                  estimate = {10 * ms, 94 * ms, 106 * ms, 211 * ms};
  using Pairs = std::vector<IndexPair>;
  EXPECT_EQ(associate(reference, estimate, {}), (Pairs{{0, 0}, {1, 1}, {1, 2}}));
  EXPECT_EQ(associate(reference, estimate, {StampRule::one_to_one, 10 * ms}), (Pairs{{0, 0}, {1, 1}}));
  EXPECT_EQ(associate({100 * ms}, estimate, {}), (Pairs{{0, 1}}));  // of two equally near the earlier one
  EXPECT_EQ(associate(reference, {}, {}), Pairs{});
}

TEST(Hungarian, AgreesWithTryingAllAssignments) {
  RandomStream random(1, "hungarian");
  int cases = 0;
  for (int rows = 1; rows <= 5; ++rows)
    for (int columns = 1; columns <= 5; ++columns) {
      Eigen::MatrixXd w(rows, columns);
      for (double& value : w.reshaped()) value = random.uniform(-0.2, 1);
      const int n = std::max(rows, columns);
      std::vector<int> order(n);
      for (int i = 0; i < n; ++i) order[i] = i;
      double best = -1e9;
      do {
        double sum = 0;
        for (int i = 0; i < rows; ++i)
          if (order[i] < columns) sum += w(i, order[i]);
        best = std::max(best, sum);
      } while (std::next_permutation(order.begin(), order.end()));
      double sum = 0;
      const auto assignment = maximum_assignment(w);
      for (int i = 0; i < rows; ++i)
        if (assignment[i] >= 0) sum += w(i, assignment[i]);
      EXPECT_NEAR(sum, best, kRounding) << rows << "x" << columns;
      ++cases;
    }
  EXPECT_EQ(cases, 25);
}

TEST(Alignment, RecoversWhatItIsFor) {
  const auto estimate = random_poses(30, 3);
  RandomStream random(4, "alignment");
  const Pose move = {random_rotation(random), Eigen::Vector3d(5, -3, 2)};
  const Pose yaw = {turn_z(2.1).rotation, Eigen::Vector3d(5, -3, 2)};
  const std::vector<std::pair<AlignmentKind, Alignment>> cases = {
      {AlignmentKind::se3, {1, move}},    {AlignmentKind::sim3, {2.5, move}},
      {AlignmentKind::posyaw, {1, yaw}},  {AlignmentKind::first, {1, move}},
      {AlignmentKind::none, {1, Pose{}}}, {AlignmentKind::scale, {0.4, Pose{}}},
      {AlignmentKind::poses, {1, move}}};
  for (const auto& [kind, transform] : cases) {
    std::vector<Pose> reference;
    for (const Pose& pose : estimate) reference.push_back(transform * pose);
    const Alignment found = align(kind, reference, estimate);
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      const PoseError error = absolute_error(reference[i], found * estimate[i]);
      ASSERT_NEAR(error.translation_m, 0, 1e-11) << static_cast<int>(kind);
      ASSERT_NEAR(error.rotation_rad, 0, 1e-11) << static_cast<int>(kind);
    }
  }
  EXPECT_EQ(cases.size(), 7u);
}

TEST(Alignment, LeastSquaresIsAMinimum) {
  auto estimate = random_poses(30, 5), reference = random_poses(30, 6);
  const Alignment best = align(AlignmentKind::sim3, reference, estimate);
  const auto cost = [&](const Alignment& a) {
    double sum = 0;
    for (std::size_t i = 0; i < estimate.size(); ++i)
      sum += std::pow(absolute_error(reference[i], a * estimate[i]).translation_m, 2);
    return sum;
  };
  for (int k = 0; k < 7; ++k)
    for (const double step : {-1e-3, 1e-3}) {
      Alignment other = best;
      Vector6d twist = Vector6d::Zero();
      if (k < 6) twist[k] = step;
      other.reference_from_estimate = exp_se3(twist) * other.reference_from_estimate;
      if (k == 6) other.scale += step;
      EXPECT_GT(cost(other), cost(best));
    }
}

TEST(Alignment, PosesAreLeastSquaresOfPositionsAndOrientations) {
  constexpr double kLever_m = 3;
  RandomStream random(7, "poses");
  auto estimate = random_poses(20, 8), reference = estimate;
  for (Pose& pose : reference)
    pose = {exp_so3(random_vector(random, 0.2)) * pose.rotation,
            pose.translation + random_vector(random, 0.3)};
  const Alignment best = align(AlignmentKind::poses, reference, estimate, kLever_m);
  const auto cost = [&](const Alignment& a) {
    double sum = 0;
    for (std::size_t i = 0; i < estimate.size(); ++i) {
      const Pose moved = a * estimate[i];
      sum += (moved.translation - reference[i].translation).squaredNorm();
      sum += kLever_m * kLever_m / 2 *
             (moved.rotation.toRotationMatrix() - reference[i].rotation.toRotationMatrix()).squaredNorm();
    }
    return sum;
  };
  for (int k = 0; k < 6; ++k)
    for (const double step : {-1e-3, 1e-3}) {
      Vector6d twist = Vector6d::Zero();
      twist[k] = step;
      EXPECT_GT(cost({1, exp_se3(twist) * best.reference_from_estimate}), cost(best)) << k;
    }
}

TEST(Alignment, RefusesWhatLeavesItOpen) {
  std::vector<Pose> line;
  for (int i = 0; i < 5; ++i) line.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(0, 0, i)});
  for (const auto kind :
       {AlignmentKind::se3, AlignmentKind::sim3, AlignmentKind::scale, AlignmentKind::posyaw})
    EXPECT_THROW(align(kind, line, line), InputError);
  for (Pose& pose : line)
    pose.translation.head<2>() = Eigen::Vector2d(0.1, 0.7);  // whose mean is off by rounding
  line.resize(7, line.back());
  EXPECT_THROW(align(AlignmentKind::posyaw, line, line), InputError);
  EXPECT_THROW(align(AlignmentKind::se3, {line[0], line[1]}, {line[0], line[1]}), InputError);
  EXPECT_NO_THROW(align(AlignmentKind::poses, line, line));  // orientations fix it
  for (const auto kind : {AlignmentKind::first, AlignmentKind::poses})
    EXPECT_THROW(align(kind, {}, {}), InputError);
}

TEST(Alignment, SaysWhichPositionsLeaveItOpen) {
  std::vector<Pose> line, level, point, curve;
  for (int i = 0; i < 6; ++i) {
    const auto add = [](std::vector<Pose>& poses, double x, double y, double z) {
      poses.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, z)});
    };
    add(line, 0.1, 0.7, i);
    add(level, 0.1 * i, 0.7 * i, 3);
    add(point, 4e5 + 0.1, 5e6 + 0.7, -0.3);  // whose mean is off by rounding
    add(curve, std::cos(i), std::sin(i), 0.1 * i);
  }
  const auto refusal = [](AlignmentKind kind, const auto& reference, const auto& estimate) {
    try {
      align(kind, reference, estimate);
    } catch (const OpenAlignment& e) {
      return std::string(e.of_reference ? "reference: " : "") + e.what();
    }
    return std::string("none");
  };
  using enum AlignmentKind;
  EXPECT_EQ(refusal(se3, line, line),
            "alignment se3: the 6 positions lie on a line, which leaves the rotation open");
  EXPECT_EQ(refusal(scale, level, level),
            "alignment scale: the 6 positions lie on a line, which leaves the rotation of sim3, whose scale "
            "this is, open");
  EXPECT_EQ(refusal(sim3, curve, line),
            "alignment sim3: the 6 positions of the estimate lie on a line, which leaves the rotation open");
  EXPECT_EQ(refusal(sim3, level, curve),
            "reference: alignment sim3: the 6 positions of the reference lie on a line, which leaves the "
            "rotation open");
  EXPECT_EQ(
      refusal(sim3, curve, point),
      "alignment sim3: the 6 positions of the estimate lie in one point, which leaves the rotation open");
  EXPECT_EQ(
      refusal(posyaw, point, curve),
      "reference: alignment posyaw: the 6 positions of the reference lie in one point, which leaves the "
      "yaw open");
  EXPECT_EQ(refusal(posyaw, line, line),
            "alignment posyaw: the 6 positions lie on a vertical line, which leaves the yaw open");
  EXPECT_EQ(refusal(posyaw, level, level), "none");
  // a whole turn, seen the other way round: every yaw is as good
  std::vector<Pose> square, turned;
  for (const auto& [x, y] : {std::pair{1, 0}, {0, 1}, {-1, 0}, {0, -1}}) {
    square.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, y, 0)});
    turned.push_back({Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, -y, 0)});
  }
  EXPECT_EQ(
      refusal(posyaw, square, turned),
      "alignment posyaw: the 4 positions of reference and estimate have nothing in common that would tell "
      "the yaw");
}

TEST(Symmetry, RenamedAxesAreUndone) {
  RandomStream random(7, "names");
  const Ellipsoid truth = body(random_rotation(random), {0.3, 0.2, 0.1});
  for (const auto& P : box_rotations()) {
    const Ellipsoid renamed = relabel_axes(truth, P);
    const Ellipsoid back = relabel_axes(renamed, best_relabelling({renamed}, {truth}));
    EXPECT_EQ(back.semi_axes_m, truth.semi_axes_m);
    EXPECT_NEAR(absolute_error(back.world_from_object, truth.world_from_object).rotation_rad, 0, kRounding);
    EXPECT_NEAR(shape_distance_m(renamed, truth), 0, 1e-9);
  }
}

TEST(Symmetry, RotationErrorByClassOfTheTrueAxes) {
  const Eigen::Quaterniond none = Eigen::Quaterniond::Identity(), z = turn_z(1).rotation;
  const Eigen::Quaterniond x(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX())),
      flip = turn_z(pi - 0.1).rotation;
  EXPECT_EQ(symmetric_rotation_error(body(z, {1, 1, 1}), body(none, {1, 1.04, 1})), std::nullopt);
  EXPECT_NEAR(*symmetric_rotation_error(body(z, {1, 1, 2}), body(none, {1, 1, 2})), 0, kRounding);
  EXPECT_NEAR(*symmetric_rotation_error(body(x * z, {1, 1, 2}), body(none, {1, 1, 2})), 0.2, kRounding);
  EXPECT_NEAR(*symmetric_rotation_error(body(flip, {1, 2, 3}), body(none, {1, 2, 3})), 0.1, kRounding);
  EXPECT_NEAR(*symmetric_rotation_error(body(z, {1, 2, 3}), body(none, {1, 2, 3})), 1, kRounding);
}

TEST(Symmetry, ShapeDistanceClosedForms) {
  const Eigen::Quaterniond none = Eigen::Quaterniond::Identity();
  Ellipsoid moved = body(none, {1, 2, 3});
  moved.world_from_object.translation += Eigen::Vector3d(0, 3, 4);
  EXPECT_NEAR(shape_distance_m(moved, body(none, {1, 2, 3})), 5, kRounding);
  // aligned bodies: BW is the distance of the semi-axes
  EXPECT_NEAR(shape_distance_m(body(none, {1, 2, 3}), body(none, {1.3, 2.3, 3.3})), 0.3, kRounding);
  EXPECT_EQ(shape_distance_m(moved, moved), 0);
}

}  // namespace uniquadric
