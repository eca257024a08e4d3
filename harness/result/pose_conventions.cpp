#include "harness/result/pose_conventions.h"

#include <algorithm>
#include <cmath>

#include "core/sequence/stamps.h"
#include "evaluation/align/alignment.h"
#include "evaluation/association/stamps.h"
#include "evaluation/trajectory/pose_error.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {
namespace {

constexpr double kFarBetter = 4;            // ours: a wrong convention is off by as much as the path itself
constexpr double kLeastMisfit = 0.02;       // ours: of the path's spread; what fits better is right
constexpr double kLeastTurn_rad = 0.1;      // ours: objects that hardly turn say nothing
constexpr double kIdentityRounding = 1e-6;  // of a written 1

struct Reading {
  bool wxyz = false, inverse = false;
};

Pose read_as(const Reading& reading, const Pose& pose) {
  const Eigen::Quaterniond& q = pose.rotation;
  Pose result = pose;
  if (reading.wxyz) result.rotation = Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w());
  return reading.inverse ? result.inverse() : result;
}

PosePairs pairs_of(const Trajectory& reference, const Trajectory& estimate) {
  const auto stamps_ns = stamps_of(reference);
  const StampOptions options{StampRule::one_to_one,
                             std::max<std::int64_t>(median_period_ns(stamps_ns) / 2, 1)};
  PosePairs pairs;
  for (const IndexPair& pair : associate(stamps_ns, stamps_of(estimate), options)) {
    pairs.reference.push_back(reference[pair.reference].pose);
    pairs.estimate.push_back(estimate[pair.estimate].pose);
  }
  return pairs;
}

double spread_m(const std::vector<Pose>& poses) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Pose& pose : poses) mean += pose.translation / static_cast<double>(poses.size());
  double squares = 0;
  for (const Pose& pose : poses) squares += (pose.translation - mean).squaredNorm();
  return std::sqrt(squares / static_cast<double>(poses.size()));
}

// Root mean square of what is left after alignment, a turn of 1 rad being `lever_m` metres.
double misfit_m(const PosePairs& pairs, const Reading& reading, double lever_m) {
  std::vector<Pose> estimate;
  for (const Pose& pose : pairs.estimate) estimate.push_back(read_as(reading, pose));
  const Alignment alignment = align(AlignmentKind::poses, pairs.reference, estimate, lever_m);
  double squares = 0;
  for (std::size_t i = 0; i < estimate.size(); ++i) {
    const PoseError error = absolute_error(pairs.reference[i], alignment * estimate[i]);
    squares += std::pow(error.translation_m, 2) + std::pow(lever_m * error.rotation_rad, 2);
  }
  return std::sqrt(squares / static_cast<double>(estimate.size()));
}

std::string words_of(const Reading& reading) {
  return std::string("poses look like ") +
         (reading.inverse ? "world-to-camera (expected is world_from_camera)" : "") +
         (reading.wxyz && reading.inverse ? " with " : "") +
         (reading.wxyz ? "quaternions in the order w x y z (expected is x y z w)" : "");
}

// Mean angle between the turns since the first pose, in the true world.
double turn_error_rad(const PosePairs& pairs, const Pose& truth_from_estimate, const Reading& reading) {
  const auto turn = [](const Pose& first, const Pose& pose) {
    return pose.rotation * first.rotation.conjugate();
  };
  const auto read = [&](const Pose& pose) { return truth_from_estimate * read_as(reading, pose); };
  double sum = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i)
    sum += turn(pairs.reference.front(), pairs.reference[i])
               .angularDistance(turn(read(pairs.estimate.front()), read(pairs.estimate[i])));
  return sum / static_cast<double>(pairs.size());
}

}  // namespace

std::optional<std::string> camera_convention_fault(const Trajectory& reference, const Trajectory& estimate) {
  const PosePairs pairs = pairs_of(reference, estimate);
  if (pairs.size() < kMinPairs) return std::nullopt;
  const double spread = spread_m(pairs.reference), lever_m = spread > 0 ? spread : 1;
  const double as_read_m = misfit_m(pairs, {}, lever_m);
  if (as_read_m < kLeastMisfit * lever_m) return std::nullopt;
  Reading best;
  double best_m = as_read_m / kFarBetter;
  for (const Reading& reading : {Reading{true, false}, Reading{false, true}, Reading{true, true}})
    if (const double other_m = misfit_m(pairs, reading, lever_m); other_m < best_m)
      best = reading, best_m = other_m;
  if (!best.wxyz && !best.inverse) return std::nullopt;
  return words_of(best);
}

std::optional<std::string> first_quaternion_fault(const Trajectory& trajectory) {
  if (trajectory.empty() || std::abs(trajectory.front().pose.rotation.x()) < 1 - kIdentityRounding)
    return std::nullopt;
  return "the first quaternion is 1 0 0 0: in the order x y z w, which is expected, that is half a turn "
         "about x; "
         "the identity is 0 0 0 1";
}

std::optional<std::string> object_convention_fault(const Trajectory& reference, const Trajectory& estimate,
                                                   const Pose& truth_from_estimate) {
  const PosePairs pairs = pairs_of(reference, estimate);
  if (pairs.size() < kMinPairs) return std::nullopt;
  const double as_read_rad = turn_error_rad(pairs, truth_from_estimate, {});
  const double other_rad = turn_error_rad(pairs, truth_from_estimate, {true, false});
  if (as_read_rad < kLeastTurn_rad || other_rad > as_read_rad / kFarBetter) return std::nullopt;
  return words_of({true, false});
}

}  // namespace uniquadric
