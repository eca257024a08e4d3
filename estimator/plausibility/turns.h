#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/imu.h"
#include "estimator/plausibility/frame_pairs.h"

namespace uniquadric {

/// How the camera turned from one time to another.
struct Turn {
  std::int64_t from_ns = 0, to_ns = 0;
  Eigen::Vector3d vector = Eigen::Vector3d::Zero();  ///< rotation vector of from_from_to, camera axes [rad]
};

/// By the pairs that have a motion.
std::vector<Turn> turns_of(const Sequence& sequence, const std::vector<FramePair>& pairs);

/// The same intervals by a gyroscope, its own axes, `late_ns` later, its rates times `scale`; nothing for
/// those beyond its readings.
std::vector<std::optional<Eigen::Vector3d>> turns_by(const std::vector<ImuSample>& samples,
                                                     const std::vector<Turn>& turns, std::int64_t late_ns,
                                                     double scale = 1);

/// Mean difference of turns and of others that are to be the same, over the mean of the turns; where others
/// are missing they do not count. Nothing where more than half are missing.
using ChangeOfTurn = std::function<Eigen::Vector3d(const Eigen::Vector3d&)>;
std::optional<double> disagreement(const std::vector<Turn>& turns,
                                   const std::vector<std::optional<Eigen::Vector3d>>& others,
                                   const ChangeOfTurn& change);

/// The rotation that lays the others on the turns best (Kabsch); the identity where all are missing.
Eigen::Matrix3d best_rotation(const std::vector<Turn>& turns,
                              const std::vector<std::optional<Eigen::Vector3d>>& others);

/// Median angle [rad]; 0 for none.
double usual_turn(const std::vector<Turn>& turns);

}  // namespace uniquadric
