#pragma once

#include <gtest/gtest.h>

#include <numbers>

#include "core/sequence/trajectory.h"
#include "evaluation/trajectory_comparison.h"
#include "tests/evaluation/random_ellipsoid.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {

constexpr double kPoseRounding = 1e-9;  // m or rad, of sums over some hundred poses of a few metres
constexpr std::int64_t kTick_ns = 100'000'000;
constexpr double kDegree = std::numbers::pi / 180;

inline Eigen::Quaterniond yaw(double angle) {
  return Eigen::Quaterniond(Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()));
}

// Radius 2 m about the origin, looking along the way, rising with every step.
inline std::vector<Pose> spiral(int n, double rise_m = 0) {
  std::vector<Pose> poses;
  for (int i = 0; i < n; ++i)
    poses.push_back({yaw(0.1 * i), {2 * std::cos(0.1 * i), 2 * std::sin(0.1 * i), rise_m * i}});
  return poses;
}

inline std::vector<Pose> random_walk(int n, std::uint64_t seed) {
  RandomStream random(seed, "walk");
  std::vector<Pose> poses = {{random_rotation(random), random_vector(random, 3)}};
  while (static_cast<int>(poses.size()) < n)
    poses.push_back(poses.back() * Pose{exp_so3(random_vector(random, 0.3)), random_vector(random, 0.5)});
  return poses;
}

inline Trajectory stamped(const std::vector<Pose>& poses, std::int64_t late_ns = 0) {
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

inline PosePairs pairs_of(const std::vector<Pose>& reference, const std::vector<Pose>& estimate) {
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

inline TrajectoryOptions aligned(AlignmentKind kind) {
  TrajectoryOptions options;
  options.alignment = kind;
  return options;
}

inline TrajectoryOptions over(double delta, DeltaUnit unit, bool evo = false, bool all_pairs = false) {
  TrajectoryOptions options;
  options.delta = {delta, unit, 0.1, all_pairs};
  options.evo = evo;
  return options;
}

}  // namespace uniquadric
