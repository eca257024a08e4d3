#pragma once

#include <atomic>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/base/progress.h"
#include "estimator/ego/depth_calibration.h"
#include "estimator/ego/lidar_ego.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/images/repeats.h"
#include "estimator/lidar/lidar_depth.h"
#include "estimator/mask_tracking/aot.h"
#include "estimator/perception/frame_work.h"
#include "estimator/perception/perceive.h"

namespace uniquadric {

/// What is read and measured of a sequence with images before its frames are looked at.
struct ImageInput {
  Sequence sequence;  ///< on the camera's clock; reads depth without its bias and smeared edges
  std::optional<std::map<std::int64_t, Pose>> poses;  ///< of the camera, where they are given
  PromptedSegmenter segmenter;
  std::optional<DepthBias> bias;
};

/// Throws InputError for sequences with nothing to work on (check_sequence).
ImageInput prepare_images(const Sequence& recorded, const PerceptionOptions& options,
                          const PerceiveOptions& run, std::vector<StageTime>& times);

/// The stages that each frame of a sequence with images passes, in this order. Those marked *serial* take the
/// frames one by one in their order, the others any number at once.
class ImageStages {
 public:
  /// `input`, `options`, `run` and `out` have to outlive it.
  ImageStages(const ImageInput& input, const PerceptionOptions& options, const PerceiveOptions& run,
              PerceptionWriter& out);
  ImageStages(const ImageStages&) = delete;
  ImageStages& operator=(const ImageStages&) = delete;

  void read(FrameWork& work) const;
  void check_depth(FrameWork& work);        ///< serial: refuses depth images that are no measurements
  void segment_now(FrameWork& work) const;  ///< without a tracker of masks
  void carry_masks(FrameWork& work);        ///< serial: with one
  void place_camera(FrameWork& work);       ///< serial: by LiDAR or given poses; takes the LiDAR's points
  void add_background_depth(FrameWork& work) const;  ///< of a LiDAR
  void follow_features(FrameWork& work);             ///< serial: of all bodies and of the camera
  void observe(FrameWork& work) const;               ///< observe_bodies
  void hand_over(FrameWork& work,
                 std::vector<StageTime>& times);  ///< serial: late outlines, feedback, output

  bool reads_scans() const { return lidar_ || points_; }

  /// After the last frame: warns of what was wrong, and writes what is left and the camera's trajectories.
  void finish();

 private:
  std::optional<Pose> camera_at(std::int64_t stamp_ns) const;
  bool keeps_masks() const;
  void refuse_depth(FrameWork& work);
  void add_lidar_depth(FrameWork& work);
  void say_faults() const;

  const ImageInput& input_;
  const Sequence& sequence_;
  const PerceptionOptions& options_;
  const PerceiveOptions& run_;
  PerceptionWriter& out_;
  FeatureTracker features_;
  RgbdOdometry odometry_;
  std::optional<LidarEgo> lidar_;
  std::unique_ptr<AsyncObjectTracker> tracker_;  // of masks
  std::optional<FramePointSource> points_;
  std::optional<LidarDepth> lidar_depth_;
  DepthCheck depth_check_;
  Repeats repeats_;
  cv::Mat last_rgb_;
  std::atomic<int> unusable_ = 0;  // depth images
  int depth_images_ = 0, blank_ = 0;
  Trajectory known_;                    // the camera at each frame, but from features
  std::deque<PerceivedFrame> waiting_;  // for outlines that come late
  Progress progress_;
};

}  // namespace uniquadric
