#pragma once

#include <cstdint>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/base/stopwatch.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/lidar/cluster_tracker.h"
#include "estimator/perception/perception_files.h"
#include "estimator/segmentation/segmenter_clock.h"
#include "estimator/shape/lidar_clusters.h"

namespace uniquadric {

/// How sequences without images get bodies. All numbers are ours.
struct ScanObjectOptions {
  bool enabled = true;  // or the sensor's own motion alone is followed
  bool masks = false;   // of the camera say which clusters are bodies, besides those that move
  static constexpr double mask_share = 0.5;  // of a cluster's points that lie under a mask then
  LidarClusterOptions clusters;
  ClusterTrackerOptions tracker;
  double width_deg = 120, height_deg = 100;  // of the image that an evaluation draws bodies in
  static constexpr double focal_px = 460;
  static constexpr double look_back_s =
      1;  // that a body's earlier clusters are kept for, from before it was known to be one
  static constexpr double rim_deg =
      1.75;  // what is so near to the end of the sensor's view may go on beyond it
  static constexpr double beside_deg = 0.6;  // what is so near beside a body may hide a part of it
  int max_points = 2000;                     // of a body
};

/// The camera that scans are looked at with: at the place of the sequence's, with an image of its own.
Camera scan_camera(const ScanObjectOptions& options);

/// The perception of a sequence without images: a frame is a scan's end, without a pose and bodies where the
/// sensor was lost. Warns of what is wrong with the scans (LidarEgo::scan_faults). The sensor is followed
/// first (LidarEgo), then points of each scan, put where they are at its end, are clustered above the ground,
/// tracked, and those that move become bodies, on all sides of the sensor. A body's points are put on to the
/// scan's end by its velocity along the ground (Eq. 4 without the turn). It has the ground under it
/// (`contact`), and neither outline nor features. `segmenter` (or null) runs beside the frames, and a cluster
/// that lies under one of its masks is a body, whether it moves or not. `seed` is that of the ground's
/// samples. Throws InputError as LidarEgo.
void perceive_scans(const Sequence& sequence, const LidarEgoOptions& ego, const ScanObjectOptions& options,
                    SegmenterClock* segmenter, std::uint64_t seed, bool quiet, PerceptionWriter& out,
                    std::vector<StageTime>& times);

}  // namespace uniquadric
