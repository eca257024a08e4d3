#include "estimator/plausibility/given_poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/plausibility/axis_turns.h"
#include "estimator/plausibility/pose_lookup.h"

namespace uniquadric {
namespace {

constexpr double kFar_px = 150;        // an error that is as good as any larger one
constexpr double kSound = 0.1;         // of the images' motion: poses that explain the rest are sound
constexpr double kSound_px = 1;        // and poses that are off by less
constexpr double kUseless = 0.6;       // of the images' motion, unexplained: named without a cause, too
constexpr double kMuchBetter = 0.45;   // of the error as given, where a hypothesis explains it
constexpr double kLeastMotion_px = 2;  // of a pair that says something
constexpr std::size_t kLeastPairs = 4;
constexpr double kLeastShare = 0.4;                   // of a pair's points that one motion explains
constexpr double kSameWay = 0.9;                      // cosine of both ways, of a pair that tells a scale
constexpr double kScaleOff = 0.06, kScaleSigmas = 5;  // of the logarithm: beyond, scales differ

using Change = std::function<Pose(const Pose&)>;  // from the pose in the file to the pose it was meant to be

struct Hypothesis {
  std::string cause;
  Change change;
  std::int64_t late_ns = 0;
};

Pose mirrored(const Pose& pose, const Eigen::Vector3d& signs) {
  const Eigen::Matrix3d S = signs.asDiagonal();
  return {Eigen::Quaterniond(Eigen::Matrix3d(S * pose.rotation.toRotationMatrix() * S)),
          S * pose.translation};
}

Pose with_rotation(const Pose& pose, const Eigen::Quaterniond& rotation) {
  return {rotation, pose.translation};
}

std::vector<Hypothesis> wrong_forms() {
  const auto as_w_first = [](const Pose& p) {
    const Eigen::Quaterniond& q = p.rotation;
    return with_rotation(p, Eigen::Quaterniond(q.x(), q.y(), q.z(), q.w()));
  };
  std::vector<Hypothesis> list;
  const auto add = [&](std::string cause, Change change) {
    list.push_back({std::move(cause), std::move(change), 0});
  };
  add("poses look inverted (camera_from_world in place of world_from_camera)",
      [](const Pose& p) { return p.inverse(); });
  add("quaternions look like w x y z in place of x y z w", as_w_first);
  add("rotations look inverted, positions do not",
      [](const Pose& p) { return with_rotation(p, p.rotation.conjugate()); });
  for (int axis = 0; axis < 3; ++axis) {
    Eigen::Vector3d signs = Eigen::Vector3d::Ones();
    signs[axis] = -1;
    add(fmt::format("poses look left-handed ({} axis mirrored)", "xyz"[axis]),
        [signs](const Pose& p) { return mirrored(p, signs); });
    add(fmt::format("positions look mirrored along {}", "xyz"[axis]), [signs](const Pose& p) {
      return Pose{p.rotation, signs.cwiseProduct(p.translation)};
    });
  }
  for (const auto& [unit, metres] : {std::pair("millimetres", 1e-3), {"centimetres", 1e-2}, {"feet", 0.3048}})
    add(fmt::format("positions look like {}", unit), [metres](const Pose& p) {
      return Pose{p.rotation, metres * p.translation};
    });
  return list;
}

// The camera's axes are others: x forward, y up, ...
std::vector<Hypothesis> other_axes() {
  std::vector<Hypothesis> list;
  for (const AxisTurn& turn : proper_axis_turns())
    if (!turn.matrix.isIdentity())
      list.push_back(
          {fmt::format("poses look like those of other camera axes (x y z is {} of the optical frame, "
                       "whose z looks forward)",
                       turn.name),
           [q = Eigen::Quaterniond(turn.matrix)](const Pose& p) { return with_rotation(p, p.rotation * q); },
           0});
  return list;
}

double period_ns(const Sequence& sequence) {
  const auto& frames = sequence.frames;
  return static_cast<double>(frames.back().stamp_ns - frames.front().stamp_ns) /
         static_cast<double>(frames.size() - 1);
}

std::vector<Hypothesis> other_times(const Sequence& sequence) {
  std::vector<Hypothesis> list;
  for (int k = -8; k <= 8; ++k)
    if (k != 0)
      list.push_back({fmt::format("poses look {} by {} frames", k > 0 ? "late" : "early", std::abs(k)),
                      [](const Pose& p) { return p; }, static_cast<std::int64_t>(k * period_ns(sequence))});
  return list;
}

// Median distance of the points from where the motion puts them.
double error_px(const FramePair& pair, const Camera& camera, const Pose& b_from_a) {
  std::vector<double> errors;
  for (const PointPair& point : pair.points) {
    if (!point.is_inlier) continue;
    const auto pixel = moved_pixel(point, camera, b_from_a);
    errors.push_back(pixel ? std::min(kFar_px, (*pixel - point.b).norm()) : kFar_px);
  }
  return quantile(std::move(errors), 0.5);
}

// Over the pairs; nothing where too few have poses.
std::optional<double> error_px(const Sequence& sequence, const std::vector<const FramePair*>& pairs,
                               const Hypothesis& hypothesis) {
  double sum = 0;
  std::size_t count = 0;
  for (const FramePair* pair : pairs) {
    const auto a =
        pose_near(*sequence.given_camera, sequence.frames[pair->first].stamp_ns + hypothesis.late_ns);
    const auto b =
        pose_near(*sequence.given_camera, sequence.frames[pair->second].stamp_ns + hypothesis.late_ns);
    if (!a || !b) continue;
    sum += error_px(*pair, sequence.camera, relative_pose(hypothesis.change(*b), hypothesis.change(*a)));
    ++count;
  }
  if (count < kLeastPairs || 2 * count < pairs.size()) return std::nullopt;
  return sum / static_cast<double>(count);
}

// Those in which the images move.
std::vector<const FramePair*> moving(const Sequence& sequence, const std::vector<FramePair>& pairs,
                                     double& motion_px) {
  std::vector<const FramePair*> result;
  motion_px = 0;
  for (const FramePair& pair : pairs) {
    if (!pair.b_from_a || pair.share < kLeastShare) continue;
    const double moved_px = error_px(pair, sequence.camera, Pose());
    if (moved_px < kLeastMotion_px) continue;
    result.push_back(&pair);
    motion_px += moved_px;
  }
  if (!result.empty()) motion_px /= static_cast<double>(result.size());
  return result;
}

std::string best_cause(const Sequence& sequence, const std::vector<const FramePair*>& pairs, double given_px,
                       double motion_px) {
  std::vector<Hypothesis> list = wrong_forms();
  for (const auto& more : {other_axes(), other_times(sequence)})
    list.insert(list.end(), more.begin(), more.end());
  double best_px = kMuchBetter * given_px;
  std::string cause;
  if (given_px > kUseless * motion_px)
    cause = fmt::format("poses do not fit the images: off by {:.1f} px where these move by {:.1f} px",
                        given_px, motion_px);
  for (const Hypothesis& hypothesis : list) {
    const auto px = error_px(sequence, pairs, hypothesis);
    if (!px || *px >= best_px) continue;
    best_px = *px;
    cause = fmt::format("{}: off by {:.1f} px as they are, {:.1f} px then", hypothesis.cause, given_px, *px);
  }
  return cause;
}

// Of the way by odometry over the way by given poses, in each pair; for poses that fit otherwise.
std::optional<std::string> scale_cause(const Sequence& sequence, const std::vector<const FramePair*>& pairs) {
  std::vector<double> logs;
  for (const FramePair* pair : pairs) {
    const auto a = pose_near(*sequence.given_camera, sequence.frames[pair->first].stamp_ns);
    const auto b = pose_near(*sequence.given_camera, sequence.frames[pair->second].stamp_ns);
    if (!a || !b) continue;
    const Eigen::Vector3d given = relative_pose(*b, *a).translation, seen = pair->b_from_a->translation;
    if (seen.norm() < pair->least_way_m || !(given.norm() > 0)) continue;
    if (given.normalized().dot(seen.normalized()) < kSameWay) continue;
    logs.push_back(std::log(seen.norm() / given.norm()));
  }
  if (logs.size() < kLeastPairs) return std::nullopt;
  const double middle = quantile(logs, 0.5);
  std::vector<double> off;
  for (const double value : logs) off.push_back(std::abs(value - middle));
  const double sigma = kMadToSigma * quantile(off, 0.5) / std::sqrt(static_cast<double>(logs.size()));
  if (std::abs(middle) < kScaleOff || std::abs(middle) < kScaleSigmas * sigma) return std::nullopt;
  return fmt::format(
      "sequence.yaml: depth.units_per_m: depth and the poses of camera_given.tum differ in scale: ways by "
      "depth are {:.3g} times as long",
      std::exp(middle));
}

}  // namespace

std::vector<std::string> given_pose_suspicions(const Sequence& sequence,
                                               const std::vector<FramePair>& pairs) {
  if (!sequence.given_camera || sequence.given_camera->empty() || sequence.frames.size() < 2) return {};
  double motion_px = 0;
  const std::vector<const FramePair*> moved = moving(sequence, pairs, motion_px);
  if (moved.size() < kLeastPairs) return {};
  const auto given_px = error_px(sequence, moved, {"", [](const Pose& p) { return p; }});
  if (!given_px) return {};
  if (const auto cause = scale_cause(sequence, moved)) return {(sequence.folder / *cause).string()};
  if (*given_px < std::max(kSound_px, kSound * motion_px)) return {};
  const std::string cause = best_cause(sequence, moved, *given_px, motion_px);
  if (cause.empty()) return {};
  return {(sequence.folder / "camera_given.tum").string() + ": " + cause};
}

}  // namespace uniquadric
