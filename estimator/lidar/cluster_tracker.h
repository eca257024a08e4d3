#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>
#include <vector>

namespace uniquadric {

/// All numbers are ours, chosen on subway_car.
struct ClusterTrackerOptions {
  static constexpr int window_scans = 6;   // that a velocity is taken from
  static constexpr int confirm_scans = 5;  // seen so often a track can be a body
  bool moving_only = true;  // of what does not move nobody can say whether it is a body or a house
  static constexpr int moving_scans = 5;  // in a row that it has to be seen to move in, once
  static constexpr double min_way = 0.3;  // share of its extent, that it has to go then
  static constexpr int forget_scans =
      10;  // after which what moved, and did not leave its own place, rests again
  static constexpr double min_speed_mps = 0.7;    // and its speed then
  static constexpr double max_stretch_mps = 0.7;  // by which its two ends may move apart then
  // of a scan's end that faces the sensor: what it has to move by beside the one that is hidden is four times
  // what this makes its speed uncertain by
  static constexpr double end_sigma_m = 0.15;
  static constexpr double min_overlap =
      0.3;  // of the smaller box along the ground, where the last one should be now
  static constexpr double max_speed_mps =
      40;  // of what was seen once: how far away it may be when it is seen again
  static constexpr int patience_scans = 8;  // without a cluster, until a track ends
};

/// The box of a cluster along the world's axes.
struct ClusterBox {
  Eigen::Vector3d low = Eigen::Vector3d::Zero(), high = Eigen::Vector3d::Zero();  ///< [m]
  /// Whether the ends at -x, +x, -y, +y are where the sensor's view ends, not the body.
  std::array<bool, 4> cut{};
  /// Whether that end faces away from the sensor: what is seen of the body ends there, not the body.
  std::array<bool, 4> hidden{};
  std::array<double, 4> ago_s{};  ///< before the scan's stamp that those ends were seen
};

/// A cluster that belongs to a track.
struct TrackedCluster {
  int id = 0;
  Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();  ///< along the ground
  int seen_as_body = 0;                                    ///< scans, this one too; 0: not confirmed yet
};

/// Clusters over time: boxes go on at constant velocity and take the clusters that they overlap most
/// (Hungarian); what was seen once takes the nearest of the others that it may have become. The velocity is
/// that of the ends in view, by least squares over the last scans: those that face the sensor or lie across
/// the line of sight, and where there are none those that face away. A body is what moves with both its ends,
/// or clearly with the one that faces the sensor where the other one is hidden.
class ClusterTracker {
 public:
  explicit ClusterTracker(const ClusterTrackerOptions& options) : options_(options) {}

  /// The clusters of the next scan: the track of each. Stamps in order.
  std::vector<TrackedCluster> track(std::int64_t stamp_ns, const std::vector<ClusterBox>& clusters);

 private:
  struct Sight {
    std::int64_t stamp_ns = 0;
    ClusterBox box;
  };
  struct Track {
    int id = 0, seen = 0, seen_as_body = 0, missed = 0, moving = 0, resting = 0;
    bool moved = false;
    double way_m = 0;                                 // since it has been moving
    Eigen::Vector2d start = Eigen::Vector2d::Zero();  // where it was seen first
    std::deque<Sight> sights;
    Eigen::Vector2d velocity_mps = Eigen::Vector2d::Zero();
  };
  void add(Track& track, std::int64_t stamp_ns, const ClusterBox& box) const;
  bool follow_ends(Track& track, int axis) const;
  void note_motion(Track& track, bool is_moving) const;
  static void start_moving(Track& track);
  std::vector<int> tracks_of(std::int64_t stamp_ns, const std::vector<ClusterBox>& clusters) const;
  void catch_up(std::int64_t stamp_ns, const std::vector<ClusterBox>& clusters,
                std::vector<int>& tracks) const;

  ClusterTrackerOptions options_;
  std::vector<Track> tracks_;
  int last_id_ = 0;
};

}  // namespace uniquadric
