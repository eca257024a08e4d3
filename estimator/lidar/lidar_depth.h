#pragma once

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/lidar/body_twist.h"
#include "estimator/lidar/frame_points.h"
#include "estimator/lidar/point_planes.h"
#include "estimator/observation/perception.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// Where the motion comes from that is undone of a body.
enum class MotionSource {
  points,    ///< ours: the body's points of the last time and where its features were (BodyTwist)
  features,  ///< its features' rigid motion over the last step, as moved() is told
};

/// All numbers are ours.
struct LidarDepthOptions {
  Undistortion undistortion = Undistortion::object;
  MotionSource motion = MotionSource::points;
  static constexpr double motion_window_s = 0.2;  // of points that a motion is found from
  BodyTwistOptions twist;
  static constexpr double window_s = 0.1;  // of points behind each frame: a scan of most sensors
  int erode_px = 1;                        // of masks, before points are said to be a body's
  PointPlaneOptions planes;
  int max_points = 2000;  // of a body
};

/// Depth of one frame from LiDAR points.
struct LidarView {
  cv::Mat depth;  ///< CV_32FC1 [m], 0 where no point is near: planes along the line of sight through points
  std::map<int, SurfacePoints> bodies;  ///< points of each mask, camera frame, at the frame's time
};

/// The part of the options that FramePointSource wants.
FramePointOptions frame_point_options(const LidarDepthOptions& options);

/// Makes depth for camera frames out of LiDAR points: of the last window_s, each where its surface is at the
/// frame's time (motion-aware undistortion, Eq. 2 to 4), projected into the image; around each a plane
/// through its nearest neighbours of the same body is laid, and neighbours across a jump in depth are left
/// out. A body's motion is that which lays its own points of different ages on one surface and brings its
/// features to where they were a frame ago. The paper prints the correction of bodies without its direction;
/// ours is p(t_frame) = T_world_object(t_frame) T_world_object(t)^-1 p(t).
class LidarDepth {
 public:
  /// The sequence's camera and LiDAR.
  LidarDepth(const Sequence& sequence, const LidarDepthOptions& options);

  /// Of what is not on bodies: the first step, which may be taken for any frame at any time and on any
  /// thread. `masks` CV_16UC1 labels, 0 background, or empty. Empty without a camera pose.
  cv::Mat background(const FramePoints& points, const cv::Mat& masks) const;

  /// Frames in their order. `depth` is the background's, to which the bodies' is added. Nothing without a
  /// camera pose.
  LidarView at(const FramePoints& points, const cv::Mat& masks, cv::Mat depth);

  /// Features of the bodies in the last frame, of which motions are found (MotionSource::points).
  void saw(const std::map<int, std::vector<Feature>>& features);

  /// How a body moved in the world over the step that ended at the last frame: p_now = motion * p_before. It
  /// counts for that frame and, where none is told for it, for the next one: then the body is hidden, and may
  /// turn or stop. With MotionSource::points it does not count.
  void moved(int label, const Pose& world_motion, std::int64_t step_ns);

 private:
  struct Held {
    LabelledPoint point;
    Eigen::Vector3d at_frame;  // world, where its surface is at the last frame's time
  };
  void advance(std::int64_t to_ns);
  std::map<int, std::vector<ImagePoint>> samples(const Pose& camera_from_world, const cv::Mat& masks) const;
  bool finds_motions() const;
  void find_motions(const Pose& camera_from_world);
  Pose told_motion(int label, double seconds) const;

  Camera camera_, ideal_;  // as it is, and without distortion
  Pose camera_from_lidar_;
  LidarDepthOptions options_;
  std::vector<Held> held_;
  struct Told {
    Vector6d twist;  // of a body's world motion over one second
    int frames = 0;  // since it was told
  };
  std::map<int, Told> motions_;  // of the bodies
  struct Found {
    BodyTwist twist;
    std::int64_t seen_ns = 0;  // when the body last had points
  };
  std::map<int, Found> twists_;                          // at the last frame
  std::map<std::int64_t, Eigen::Vector2d> last_pixels_;  // of feature tracks
  std::int64_t last_ns_ = 0, before_last_ns_ = 0;
  std::optional<Pose> last_, before_last_;  // world_from_camera
};

}  // namespace uniquadric
