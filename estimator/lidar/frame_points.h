#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/lidar/point_planes.h"

namespace uniquadric {

/// What is undone of the motion during a scan (the paper's Fig. on undistortion).
enum class Undistortion {
  none,    ///< nothing: points lie where the sensor saw them from where it is now
  ego,     ///< the sensor's own motion (Eq. 2, 3)
  object,  ///< and that of each body (Eq. 4)
};

/// A LiDAR point on a body.
struct LabelledPoint {
  std::int64_t stamp_ns = 0;
  Eigen::Vector3d seen = Eigen::Vector3d::Zero();  ///< world, where the point's surface was then
  Eigen::Vector3d in_lidar = Eigen::Vector3d::Zero();
  int label = 0;  ///< of the mask that it falls into
};

/// What a LiDAR shows of one frame of the camera, its own motion undone.
struct FramePoints {
  std::int64_t stamp_ns = 0, last_stamp_ns = 0;            ///< of this frame and the one before it
  std::optional<Pose> world_from_camera, world_from_last;  ///< at these stamps
  std::vector<LabelledPoint> on_bodies;                    ///< that came since the frame before
  std::vector<ImagePoint> background;                      ///< of the window, near bodies
};

/// All numbers are ours.
struct FramePointOptions {
  Undistortion undistortion = Undistortion::object;
  double window_s = 0.1;  // of points behind each frame: a scan of most sensors
  int erode_px = 1;       // of masks, before points are said to be a body's
  double reach_px = 14;   // around bodies, of background that is kept
};

/// Cuts a LiDAR's points to camera frames by their own stamps and puts them into the world, by where the
/// camera was when each was seen.
class FramePointSource {
 public:
  using CameraPath = std::function<std::optional<Pose>(std::int64_t stamp_ns)>;  ///< world_from_camera

  /// The sequence has to outlive this. Throws InputError as require_scans() does.
  FramePointSource(const Sequence& sequence, CameraPath path, const FramePointOptions& options);

  /// Frames in their order, as soon as the path is known to there. `masks` CV_16UC1 labels, 0 background, or
  /// empty. No points without a camera pose.
  FramePoints take(std::int64_t stamp_ns, std::int64_t next_stamp_ns, const cv::Mat& masks);

  /// Of the scans that were read.
  const ScanWatch& watch() const { return stream_.watch(); }

 private:
  void receive(std::int64_t until_ns, const cv::Mat& masks, FramePoints& frame);
  void keep_background(const cv::Mat& masks, FramePoints& frame) const;

  Camera camera_;
  Pose camera_from_lidar_;
  CameraPath path_;
  FramePointOptions options_;
  LidarStream stream_;
  std::deque<LabelledPoint> background_;  // of the window
  std::int64_t last_ns_ = 0;
};

/// The label of the masks at a pixel; 0 where there are no masks, nobody's outside of them.
int label_at(const cv::Mat& masks, const Eigen::Vector2d& pixel);

}  // namespace uniquadric
