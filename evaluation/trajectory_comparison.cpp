#include "evaluation/trajectory_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/base/error.h"
#include "core/sequence/stamps.h"
#include "core/sequence/trajectory.h"
#include "core/sequence/tum_as_written.h"
#include "evaluation/association/evo_stamps.h"
#include "evaluation/trajectory/evo_steps.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// One of the two trajectories, and what messages call it.
struct NamedPoses {
  fs::path name;
  WrittenPoses written;
};

NamedPoses named(const fs::path& name, WrittenPoses written) {
  if (written.poses.empty()) throw InputError(name, "has no poses");
  return {name, std::move(written)};
}

// evo takes poses in the order of the file, equal stamps too.
NamedPoses read_poses(const fs::path& path, bool as_written) {
  return named(path, as_written ? read_tum_as_written(path) : WrittenPoses{read_tum(path), {}});
}

NamedPoses poses_in_memory(const char* name, const Trajectory& trajectory) {
  WrittenPoses written{trajectory, {}};
  for (const StampedPose& pose : trajectory)
    written.stamps_s.push_back(static_cast<double>(pose.stamp_ns) / 1e9);
  return named(name, std::move(written));
}

double path_m(const Trajectory& trajectory) {
  double length_m = 0;
  for (std::size_t i = 1; i < trajectory.size(); ++i)
    length_m += (trajectory[i].pose.translation - trajectory[i - 1].pose.translation).norm();
  return length_m;
}

std::vector<IndexPair> pairs_of(const WrittenPoses& reference, const WrittenPoses& estimate,
                                const TrajectoryOptions& options) {
  if (!options.evo)
    return associate(stamps_of(reference.poses), stamps_of(estimate.poses), options.association);
  return associate_as_evo(reference.stamps_s, estimate.stamps_s,
                          static_cast<double>(options.association.max_difference_ns) / 1e9);
}

void pair_up(const Trajectory& reference, const Trajectory& estimate, const std::vector<IndexPair>& pairs,
             TrajectoryComparison& result) {
  result.pairs.stamps_ns.reserve(pairs.size());
  result.pairs.reference.reserve(pairs.size());
  result.pairs.estimate.reserve(pairs.size());
  std::vector<bool> covered(reference.size());  // poses of the reference may stand in several pairs
  for (const IndexPair& pair : pairs) {
    result.pairs.stamps_ns.push_back(reference[pair.reference].stamp_ns);
    result.pairs.reference.push_back(reference[pair.reference].pose);
    result.pairs.estimate.push_back(estimate[pair.estimate].pose);
    covered[pair.reference] = true;
  }
  result.coverage =
      static_cast<double>(std::ranges::count(covered, true)) / static_cast<double>(reference.size());
}

void align_estimate(const TrajectoryOptions& options, TrajectoryComparison& result) {
  PosePairs& pairs = result.pairs;
  const std::size_t n = std::min(options.align_pairs.value_or(pairs.size()), pairs.size());
  const auto first = [n](const std::vector<Pose>& poses) {
    return std::vector<Pose>(poses.begin(), poses.begin() + static_cast<std::ptrdiff_t>(n));
  };
  result.aligned_pairs = options.alignment == AlignmentKind::none    ? 0
                         : options.alignment == AlignmentKind::first ? 1
                                                                     : n;
  const Alignment fitted = n == pairs.size()
                               ? align(options.alignment, pairs.reference, pairs.estimate)
                               : align(options.alignment, first(pairs.reference), first(pairs.estimate));
  // No rounding of a fit where there is nothing to align: a perfect estimate has no error at all.
  if (std::equal(pairs.reference.begin(), pairs.reference.end(), pairs.estimate.begin(), same_pose)) return;
  result.alignment = fitted;
  if (options.alignment == AlignmentKind::none) return;
  for (Pose& pose : pairs.estimate) pose = fitted * pose;
}

std::vector<IndexStep> steps_of(const PosePairs& pairs, const TrajectoryOptions& options) {
  const auto& poses = options.pairs_from_reference.value_or(!options.evo) ? pairs.reference : pairs.estimate;
  const auto steps =
      options.evo ? evo_steps(poses, options.delta) : delta_steps(poses, pairs.stamps_ns, options.delta);
  if (steps.empty())
    throw InputError(fmt::format("delta {}{}: no two of the {} pairs of poses lie that far apart",
                                 options.delta.delta, to_string(options.delta.unit), pairs.size()));
  return steps;
}

double absolute_part(const Pose& reference, const Pose& estimate, ErrorPart part) {
  if (part == ErrorPart::full) return full_absolute_error(reference, estimate);
  return part == ErrorPart::translation ? absolute_distance_m(reference, estimate)
                                        : absolute_angle_rad(reference, estimate);
}

double part_of(const PoseError& error, ErrorPart part) {
  return part == ErrorPart::translation ? error.translation_m : error.rotation_rad;
}

ErrorSeries absolute_series(const PosePairs& pairs, ErrorPart part) {
  ErrorSeries series{PoseRelation::ape, part, {}, {}};
  series.at.reserve(pairs.size());
  series.values.reserve(pairs.size());
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    series.at.push_back(k);
    series.values.push_back(absolute_part(pairs.reference[k], pairs.estimate[k], part));
  }
  return series;
}

ErrorSeries relative_series(const PosePairs& pairs, const std::vector<IndexStep>& steps, ErrorPart part) {
  ErrorSeries series{PoseRelation::rpe, part, {}, {}};
  for (const auto& [i, j] : steps) {
    const Pose &from = pairs.reference[i], &to = pairs.reference[j];
    const Pose &estimate_from = pairs.estimate[i], &estimate_to = pairs.estimate[j];
    series.at.push_back(j);
    series.values.push_back(part == ErrorPart::full
                                ? full_relative_error(from, to, estimate_from, estimate_to)
                                : part_of(relative_error(from, to, estimate_from, estimate_to), part));
  }
  return series;
}

void require_pairs(const NamedPoses& reference, const NamedPoses& estimate, const PosePairs& pairs,
                   const TrajectoryOptions& options) {
  if (pairs.size() >= kMinPairs) return;
  throw InputError(estimate.name,
                   fmt::format("{} of {} poses lie within {} s of the reference's {}, at least {} are needed",
                               pairs.size(), estimate.written.poses.size(),
                               static_cast<double>(options.association.max_difference_ns) * 1e-9,
                               reference.written.poses.size(), kMinPairs));
}

TrajectoryComparison pair_and_align(const NamedPoses& reference, const NamedPoses& estimate,
                                    const TrajectoryOptions& options) {
  const Trajectory &true_poses = reference.written.poses, &poses = estimate.written.poses;
  TrajectoryComparison result;
  result.reference_poses = true_poses.size();
  result.estimate_poses = poses.size();
  result.reference_path_m = path_m(true_poses);
  result.estimate_path_m = path_m(poses);
  pair_up(true_poses, poses, pairs_of(reference.written, estimate.written, options), result);
  require_pairs(reference, estimate, result.pairs, options);
  try {
    align_estimate(options, result);
  } catch (const OpenAlignment& e) {
    throw InputError(e.of_reference ? reference.name : estimate.name, e.what());
  } catch (const InputError& e) {
    throw InputError(estimate.name, e.what());
  }
  return result;
}

TrajectoryComparison compare(const NamedPoses& reference, const NamedPoses& estimate,
                             const TrajectoryOptions& options) {
  TrajectoryComparison result = pair_and_align(reference, estimate, options);
  for (const PoseRelation relation : options.relations)
    for (const ErrorPart part : options.parts)
      result.errors.push_back(relation == PoseRelation::ape
                                  ? absolute_series(result.pairs, part)
                                  : relative_series(result.pairs, steps_of(result.pairs, options), part));
  if (options.drift) {
    result.drift = maximum_drift(result.pairs);
    result.drift_angles = drift_angles(result.pairs);
    result.calibrated = calibrated_drift(result.pairs);
  }
  if (options.kitti) result.kitti = kitti_odometry(result.pairs);
  return result;
}

}  // namespace

const char* to_string(PoseRelation relation) {
  return relation == PoseRelation::ape ? "ape" : "rpe";
}

const char* to_string(ErrorPart part) {
  return part == ErrorPart::full ? "full" : part == ErrorPart::translation ? "translation" : "rotation";
}

const char* unit_of(ErrorPart part) {
  return part == ErrorPart::full ? "" : part == ErrorPart::translation ? "m" : "rad";
}

TrajectoryComparison compare_trajectories(const fs::path& reference, const fs::path& estimate,
                                          const TrajectoryOptions& options) {
  const NamedPoses read = read_poses(reference, options.evo);  // its faults are told first
  return compare(read, read_poses(estimate, options.evo), options);
}

TrajectoryComparison compare_trajectories(const Trajectory& reference, const Trajectory& estimate,
                                          const TrajectoryOptions& options) {
  const NamedPoses named = poses_in_memory("reference", reference);
  return compare(named, poses_in_memory("estimate", estimate), options);
}

}  // namespace uniquadric
