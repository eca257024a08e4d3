// --compat evo on files whose stamps repeat or decrease, against a second computation: evo's definitions,
// with 4x4 matrices and every pair of stamps looked at.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <fstream>

#include "core/base/files.h"
#include "tests/evaluation/trajectory_fixture.h"

namespace uniquadric {
namespace {
using Matrices = std::vector<Eigen::Matrix4d>;

constexpr double kSame = 1e-6;  // of figures of some metres or radians
constexpr double kMostDifference_s = 0.01;

struct TimedMatrices {
  std::vector<double> stamps_s;
  Matrices poses;
};

// What is written, as a reader of the text sees it.
TimedMatrices parsed(const std::filesystem::path& path) {
  TimedMatrices read;
  std::ifstream in(path);
  double stamp_s, x, y, z, qx, qy, qz, qw;
  while (in >> stamp_s >> x >> y >> z >> qx >> qy >> qz >> qw) {
    read.stamps_s.push_back(stamp_s);
    read.poses.push_back(Eigen::Matrix4d::Identity());
    read.poses.back().topLeftCorner<3, 3>() = Eigen::Quaterniond(qw, qx, qy, qz).toRotationMatrix();
    read.poses.back().topRightCorner<3, 1>() = Eigen::Vector3d(x, y, z);
  }
  return read;
}

struct MatrixPairs {
  Matrices reference, estimate;
};

MatrixPairs paired(const TimedMatrices& reference, const TimedMatrices& estimate) {
  const bool estimate_is_longer = estimate.poses.size() > reference.poses.size();
  const TimedMatrices &shorter = estimate_is_longer ? reference : estimate,
                      &longer = estimate_is_longer ? estimate : reference;
  MatrixPairs pairs;
  for (std::size_t i = 0; i < shorter.poses.size(); ++i) {
    std::size_t best = 0;
    for (std::size_t j = 1; j < longer.poses.size(); ++j)
      if (std::abs(longer.stamps_s[j] - shorter.stamps_s[i]) <
          std::abs(longer.stamps_s[best] - shorter.stamps_s[i]))
        best = j;
    if (std::abs(longer.stamps_s[best] - shorter.stamps_s[i]) > kMostDifference_s) continue;
    pairs.reference.push_back(estimate_is_longer ? shorter.poses[i] : longer.poses[best]);
    pairs.estimate.push_back(estimate_is_longer ? longer.poses[best] : shorter.poses[i]);
  }
  return pairs;
}

Eigen::Matrix3Xd positions(const Matrices& poses) {
  Eigen::Matrix3Xd columns(3, static_cast<Eigen::Index>(poses.size()));
  for (std::size_t k = 0; k < poses.size(); ++k)
    columns.col(static_cast<Eigen::Index>(k)) = poses[k].topRightCorner<3, 1>();
  return columns;
}

void align_matrices(AlignmentKind kind, MatrixPairs& pairs) {
  if (kind == AlignmentKind::none) return;
  Eigen::Matrix4d left = pairs.reference[0] * pairs.estimate[0].inverse();
  double scale = 1;
  if (kind != AlignmentKind::first) {
    left = Eigen::umeyama(positions(pairs.estimate), positions(pairs.reference), kind != AlignmentKind::se3);
    scale = std::cbrt(left.topLeftCorner<3, 3>().determinant());
    left.topLeftCorner<3, 3>() /= scale;
    if (kind == AlignmentKind::scale) left.setIdentity();
  }
  for (Eigen::Matrix4d& pose : pairs.estimate) {
    pose.topRightCorner<3, 1>() *= scale;
    pose = (left * pose).eval();
  }
}

double part_of(const Eigen::Matrix4d& error, ErrorPart part) {
  if (part == ErrorPart::translation) return error.topRightCorner<3, 1>().norm();
  if (part == ErrorPart::full) return (error - Eigen::Matrix4d::Identity()).norm();
  return Eigen::AngleAxisd(Eigen::Matrix3d(error.topLeftCorner<3, 3>())).angle();
}

std::vector<std::pair<std::size_t, std::size_t>> index_steps(const Matrices& poses, double delta,
                                                             bool in_metres, bool all_pairs) {
  std::vector<std::pair<std::size_t, std::size_t>> steps;
  const std::size_t n = poses.size(), frames = static_cast<std::size_t>(delta);
  std::vector<double> path_m(n);
  for (std::size_t k = 1; k < n; ++k)
    path_m[k] = path_m[k - 1] + (poses[k] - poses[k - 1]).topRightCorner<3, 1>().norm();
  if (!in_metres)
    for (std::size_t i = 0; i + frames < n; i += all_pairs ? 1 : frames) steps.emplace_back(i, i + frames);
  if (in_metres && all_pairs)
    for (std::size_t i = 0; i + 1 < n; ++i) {
      std::size_t best = i + 1;
      for (std::size_t j = i + 1; j < n; ++j)
        if (std::abs(path_m[j] - path_m[i] - delta) < std::abs(path_m[best] - path_m[i] - delta)) best = j;
      if (std::abs(path_m[best] - path_m[i] - delta) <= 0.1 * delta) steps.emplace_back(i, best);
    }
  if (!in_metres || all_pairs) return steps;
  std::vector<std::size_t> ends;
  double since_m = 0;
  for (std::size_t k = 1; k < n; ++k) {
    since_m += path_m[k] - path_m[k - 1];
    if (since_m < delta) continue;
    ends.push_back(k);
    since_m = 0;
  }
  for (std::size_t k = 1; k < ends.size(); ++k) steps.emplace_back(ends[k - 1], ends[k]);
  return steps;
}

void expect_figures(const Statistics& figure, const std::vector<double>& errors) {
  ASSERT_EQ(figure.n, errors.size());
  const Eigen::Map<const Eigen::ArrayXd> e(errors.data(), static_cast<Eigen::Index>(errors.size()));
  EXPECT_NEAR(figure.rmse, std::sqrt(e.square().mean()), kSame);
  EXPECT_NEAR(figure.mean, e.mean(), kSame);
  EXPECT_NEAR(figure.std, std::sqrt((e - e.mean()).square().mean()), kSame);
  EXPECT_NEAR(figure.min, e.minCoeff(), kSame);
  EXPECT_NEAR(figure.max, e.maxCoeff(), kSame);
  EXPECT_NEAR(figure.sse, e.square().sum(), kSame * e.square().sum());
  std::vector<double> sorted = errors;
  std::ranges::sort(sorted);
  EXPECT_NEAR(figure.median, (sorted[sorted.size() / 2] + sorted[(sorted.size() - 1) / 2]) / 2, kSame);
}

// Stamps as TUM's ground truth and an estimate have them; `repeats` names poses with the stamp before them.
std::string tum_lines(const std::vector<Pose>& poses, double period_s,
                      const std::vector<std::size_t>& repeats, const std::vector<std::size_t>& backwards,
                      double start_s = 1311868164) {
  std::string text;
  double stamp_s = start_s;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    if (k > 0 && std::ranges::find(repeats, k) == repeats.end()) stamp_s += period_s;
    const bool early = std::ranges::find(backwards, k) != backwards.end();
    const Eigen::Vector3d& t = poses[k].translation;
    const Eigen::Quaterniond& q = poses[k].rotation;
    text += fmt::format("{:.4f} {} {} {} {} {} {} {}\n", stamp_s - (early ? 3 * period_s : 0), t.x(), t.y(),
                        t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

class EvoStamps : public CompareTrajectories {
 protected:
  // In all alignments and parts, absolute and relative errors over frames and metres.
  void expect_as_evo() const {
    constexpr std::array kAlignments = {AlignmentKind::none, AlignmentKind::first, AlignmentKind::se3,
                                        AlignmentKind::sim3, AlignmentKind::scale};
    for (const AlignmentKind kind : kAlignments)
      for (const bool in_metres : {false, true})
        for (const bool all_pairs : {false, true}) {
          SCOPED_TRACE(fmt::format("{} {} {}", to_string(kind), in_metres, all_pairs));
          expect_as_evo(kind, in_metres ? 1.5 : 3, in_metres, all_pairs);
        }
  }

 private:
  void expect_as_evo(AlignmentKind kind, double delta, bool in_metres, bool all_pairs) const {
    MatrixPairs pairs = paired(parsed(reference()), parsed(estimate()));
    align_matrices(kind, pairs);
    TrajectoryOptions options =
        over(delta, in_metres ? DeltaUnit::metres : DeltaUnit::frames, true, all_pairs);
    options.alignment = kind;
    options.parts = {ErrorPart::translation, ErrorPart::rotation, ErrorPart::full};
    const TrajectoryComparison c = compare_trajectories(reference(), estimate(), options);
    ASSERT_EQ(c.pairs.size(), pairs.reference.size());
    const auto steps = index_steps(pairs.estimate, delta, in_metres, all_pairs);
    for (const ErrorPart part : options.parts) {
      SCOPED_TRACE(to_string(part));
      std::vector<double> absolute, relative;
      for (std::size_t k = 0; k < pairs.reference.size(); ++k)
        absolute.push_back(part_of(pairs.reference[k].inverse() * pairs.estimate[k], part));
      for (const auto& [i, j] : steps)
        relative.push_back(part_of((pairs.reference[i].inverse() * pairs.reference[j]).inverse() *
                                       (pairs.estimate[i].inverse() * pairs.estimate[j]),
                                   part));
      expect_figures(figure(c, PoseRelation::ape, part), absolute);
      expect_figures(figure(c, PoseRelation::rpe, part), relative);
    }
  }
};

// The estimate: half as large, elsewhere, noisy.
std::vector<Pose> estimate_of(const std::vector<Pose>& poses) {
  RandomStream random(5, "estimate");
  const Pose elsewhere = {exp_so3({0.2, -0.4, 1}), {3, -2, 1}};
  return changed(poses, [&](std::size_t, const Pose& p) {
    const Pose noisy = p * Pose{exp_so3(random_vector(random, 0.02)), random_vector(random, 0.03)};
    return elsewhere * Pose{noisy.rotation, 0.5 * noisy.translation};
  });
}
}  // namespace

TEST_F(EvoStamps, EqualInTheReference) {
  const auto way = random_walk(120, 3);
  write_text(reference(), tum_lines(way, 0.01, {5, 6, 40, 119}, {}));
  std::vector<Pose> every_third;
  for (std::size_t k = 0; k < way.size(); k += 3) every_third.push_back(way[k]);
  write_text(estimate(), tum_lines(estimate_of(every_third), 0.03, {}, {}));
  expect_as_evo();
}

TEST_F(EvoStamps, EqualInTheEstimate) {
  const auto way = random_walk(90, 4);
  write_text(reference(), tum_lines(way, 0.02, {}, {}));
  write_text(estimate(), tum_lines(estimate_of(way), 0.02, {1, 2, 3, 30, 31, 60, 89}, {}));
  expect_as_evo();
  std::vector<Pose> longer = estimate_of(random_walk(200, 4));
  write_text(estimate(), tum_lines(longer, 0.01, {1, 2, 3, 30, 31, 60, 89, 199}, {}));
  expect_as_evo();
}

// Every stamp of the estimate lies midway between two of the reference, as far as doubles go.
TEST_F(EvoStamps, EqualInBothWithTiesAndSomeThatDecrease) {
  const auto way = random_walk(100, 6);
  write_text(reference(), tum_lines(way, 0.01, {7, 8, 9, 50}, {20, 21, 70}));
  std::vector<Pose> some(way.begin(), way.begin() + 80);
  write_text(estimate(), tum_lines(estimate_of(some), 0.01, {3, 33, 34}, {11, 60}, 1311868164.005));
  expect_as_evo();
}

TEST_F(EvoStamps, WithoutEvoTheFirstIsKept) {
  const auto way = random_walk(30, 7);
  write_text(reference(), tum_lines(way, 0.1, {10, 11}, {}));
  testing::internal::CaptureStderr();
  const TrajectoryComparison c = compare_trajectories(reference(), reference(), {});
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("2 of 30 poses repeat the timestamp before them"), std::string::npos) << said;
  EXPECT_EQ(c.pairs.size(), 28u);
  EXPECT_EQ(ape_m(c), 0);
  EXPECT_LT((c.pairs.reference[9].translation - way[9].translation).norm(), kPoseRounding);
  EXPECT_LT((c.pairs.reference[10].translation - way[12].translation).norm(), kPoseRounding);
}

}  // namespace uniquadric
