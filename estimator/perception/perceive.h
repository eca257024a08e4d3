#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <vector>

#include "core/sequence/sequence.h"
#include "estimator/base/stopwatch.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/features/features.h"
#include "estimator/lidar/lidar_depth.h"
#include "estimator/mask_tracking/aot.h"
#include "estimator/observation/silhouette.h"
#include "estimator/perception/contact_plane.h"
#include "estimator/perception/depth_check.h"
#include "estimator/perception/perception_files.h"
#include "estimator/perception/scan_objects.h"
#include "estimator/segmentation/segmentation.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// Where the camera's poses come from.
enum class EgoSource {
  given,  ///< camera_given.tum of the sequence
  rgbd,   ///< followed by the background's features and their depth (RgbdOdometry)
  lidar,  ///< from the LiDAR's points, with the IMU where there is one (LidarEgo)
};

/// Where depth comes from.
enum class DepthSource {
  recorded,  ///< the sequence's depth images, or its LiDAR where it has none
  images,
  lidar,  ///< LidarDepth
};

/// All options of the perception stage.
struct PerceptionOptions {
  bool images = true;  // false: bodies come from the scans alone, even where there are images
  std::int64_t lidar_time_offset_ns = 0;  // the LiDAR's clock less the camera's, for all that reads scans
  EgoSource ego = EgoSource::given;
  EgoOptions odometry;     // of EgoSource::rgbd
  double fixed_lag_s = 1;  // after which `fixed_lag` trajectories are known
  LidarEgoOptions lidar;   // of EgoSource::lidar
  DepthSource depth = DepthSource::recorded;
  DepthCheckOptions depth_check;  // of depth images
  /// Takes the bias of the depth images' stereo out (depth_bias). False: they are right as they are.
  bool depth_calibration = true;
  /// Takes out depth between two surfaces, where edges of depth are ramps (depth_edge_width_px).
  bool drop_smeared_edges = true;
  LidarDepthOptions lidar_depth;  // of DepthSource::lidar
  SegmentationOptions segmentation;
  AotOptions aot;
  FeatureOptions features;
  SilhouetteOptions silhouettes;
  PointOptions points;
  ContactOptions contact;
  ScanObjectOptions scan_objects;  // of scans alone
};

struct PerceiveOptions {
  Prompts prompts;
  std::uint64_t seed = 0;              ///< of the random samples
  int threads = 0;                     ///< 0: as many as the machine has
  std::filesystem::path masks_folder;  ///< where masks are written as PNG (16-bit ids); empty: nowhere
  bool quiet = false;
  BodyFeedback* feedback = nullptr;  ///< goes along frame by frame; null: nothing does
};

/// The camera whose pixels perception speaks of: the sequence's without its distortion, or one that scans are
/// looked at with where there are no images.
Camera perception_camera(const Sequence& sequence, const PerceptionOptions& options);

/// The perception stage: masks, outlines, feature tracks, depth points and the camera's poses of every frame,
/// in their order, written as they are known. The same for any number of threads. `times` receives what each
/// stage took. Warns of depth, images and scans that are no measurements. Throws InputError for sequences
/// with nothing to work on (check_sequence).
void perceive(const Sequence& sequence, const PerceptionOptions& options, const PerceiveOptions& run,
              PerceptionWriter& out, std::vector<StageTime>& times);

}  // namespace uniquadric
