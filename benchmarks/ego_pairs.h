#pragma once

#include <cmath>
#include <ctime>
#include <map>
#include <vector>

#include "core/sequence/trajectory.h"
#include "evaluation/trajectory/trajectory_error.h"

namespace uniquadric {

inline double rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v * v;
  return std::sqrt(sum / double(values.size()));
}

/// Of the processor.
inline double now_ms() {
  return 1e3 * double(std::clock()) / CLOCKS_PER_SEC;
}

/// Poses of equal stamps.
inline PosePairs pairs_of(const Trajectory& reference, const Trajectory& estimate) {
  std::map<std::int64_t, Pose> truth;
  for (const auto& [stamp, pose] : reference) truth.emplace(stamp, pose);
  PosePairs pairs;
  for (const auto& [stamp, pose] : estimate)
    if (const auto match = truth.find(stamp); match != truth.end()) {
      pairs.stamps_ns.push_back(stamp);
      pairs.reference.push_back(match->second);
      pairs.estimate.push_back(pose);
    }
  return pairs;
}

inline double path_m(const PosePairs& pairs) {
  double path = 0;
  for (std::size_t i = 1; i < pairs.size(); ++i)
    path += (pairs.reference[i].translation - pairs.reference[i - 1].translation).norm();
  return path;
}

}  // namespace uniquadric
