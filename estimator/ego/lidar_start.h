#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/ego/lidar_track.h"

namespace uniquadric {

/// Finds how a sensor moves at first. Its first sweeps are gone through from the best of some velocities, and
/// again with what was found, until it changes no more. A motion that is not known would make a map that
/// agrees with it: while sweeps do not tell it, or would fit as well to another one, more of them are waited
/// for.
class LidarStart {
 public:
  /// The setting has to outlive this.
  explicit LidarStart(const LidarSetting& setting) : setting_(setting) {}

  /// When the first points were measured; before the first sweep.
  void set_time(std::int64_t start_ns) { start_ns_ = start_ns; }
  /// Takes a sweep that ends after the one before. The track through all sweeps, once it is known.
  std::optional<LidarTrack> add(LidarSweep sweep);
  /// The same from what sweeps there are.
  std::optional<LidarTrack> finish();

 private:
  bool is_last_whole() const;
  Eigen::Vector3d likely_up() const;
  struct LevelStart {
    Eigen::Vector3d up_in_body, velocity_mps;
  };
  std::optional<LevelStart> level_start() const;
  LidarState first_guess(const Eigen::Vector3d& velocity_mps) const;
  double share_from(const Eigen::Vector3d& velocity_mps, std::size_t sweeps) const;
  Eigen::Vector3d likely_velocity() const;
  LidarState run_back(LidarState state) const;
  LidarState better_start(const LidarTrack& track) const;
  bool has_found_start(const LidarTrack& track) const;
  LidarTrack settled(const Eigen::Vector3d& velocity_mps) const;
  bool is_one_of_many(const LidarTrack& track) const;

  const LidarSetting& setting_;
  std::int64_t start_ns_ = 0;
  std::vector<LidarSweep> sweeps_;
  Eigen::Vector3d up_in_body_ = Eigen::Vector3d::UnitZ();
  double row_gap_rad_ = 0;
};

}  // namespace uniquadric
