#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/sequence/sequence.h"
#include "estimator/perception/body_twist.h"
#include "estimator/perception/lidar_stream.h"
#include "estimator/perception/perception.h"
#include "estimator/perception/point_planes.h"
#include "estimator/shape/object_points.h"

namespace uniquadric {

/// What is undone of the motion during a scan (the paper's Fig. on undistortion).
enum class Undistortion {
  none,    ///< nothing: points lie where the sensor saw them from where it is now
  ego,     ///< the sensor's own motion (Eq. 2, 3)
  object,  ///< and that of each body (Eq. 4)
};

/// Where the motion comes from that is undone of a body.
enum class MotionSource {
  points,    ///< ours: the body's points of the last time and where its features were (BodyTwist)
  features,  ///< its features' rigid motion over the last step, as moved() is told
};

/// All numbers are ours.
struct LidarDepthOptions {
  Undistortion undistortion = Undistortion::object;
  MotionSource motion = MotionSource::points;
  double motion_window_s = 0.2;  // of points that a motion is found from
  BodyTwistOptions twist;
  double window_s = 0.1;  // of points behind each frame: a scan of most sensors
  int erode_px = 1;       // of masks, before points are said to be a body's
  PointPlaneOptions planes;
  int max_points = 2000;  // of a body
};

/// Depth of one frame from LiDAR points.
struct LidarView {
  cv::Mat depth;  ///< CV_32FC1 [m], 0 where no point is near: planes along the line of sight through points
  std::map<int, SurfacePoints> bodies;  ///< points of each mask, camera frame, at the frame's time
};

/// Makes depth for camera frames out of LiDAR points: of the last window_s, each where its surface is at the
/// frame's time (motion-aware undistortion, Eq. 2 to 4), projected into the image; around each a plane
/// through its nearest neighbours of the same body is laid, and neighbours across a jump in depth are left
/// out. A body's motion is that which lays its own points of different ages on one surface and brings its
/// features to where they were a frame ago. The paper prints the correction of bodies without its direction;
/// ours is p(t_frame) = T_world_object(t_frame) T_world_object(t)^-1 p(t).
class LidarDepth {
 public:
  using CameraPath = std::function<std::optional<Pose>(std::int64_t stamp_ns)>;  ///< world_from_camera

  /// The sequence has to outlive this. Throws InputError as require_scans() does.
  LidarDepth(const Sequence& sequence, CameraPath path, const LidarDepthOptions& options);

  /// Frames in their order. `masks` CV_16UC1 labels, 0 background, or empty. Nothing without a camera pose.
  LidarView at(std::int64_t stamp_ns, std::int64_t next_stamp_ns, const cv::Mat& masks);

  /// Features of the bodies in the last frame, of which motions are found (MotionSource::points).
  void saw(const std::map<int, std::vector<Feature>>& features);

  /// How a body moved in the world over the step that ended at the last frame: p_now = motion * p_before. It
  /// counts for that frame and, where none is told for it, for the next one: then the body is hidden, and may
  /// turn or stop. With MotionSource::points it does not count.
  void moved(int label, const Pose& world_motion, std::int64_t step_ns);

  /// Of the scans that were read.
  const ScanWatch& watch() const { return stream_.watch(); }

 private:
  struct Held {
    std::int64_t stamp_ns;
    Eigen::Vector3d seen;      // world, where the point's surface was then
    Eigen::Vector3d at_frame;  // and where it is at the last frame's time
    Eigen::Vector3d in_lidar;
    int label;
  };
  void advance(std::int64_t to_ns);
  void receive(std::int64_t stamp_ns, std::int64_t until_ns, const Pose& world_from_camera,
               const cv::Mat& masks);
  bool finds_motions() const;
  void find_motions(const Pose& camera_from_world);
  Pose told_motion(int label, double seconds) const;

  Camera camera_, ideal_;  // as it is, and without distortion
  Pose camera_from_lidar_;
  CameraPath path_;
  LidarDepthOptions options_;
  LidarStream stream_;
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
};

}  // namespace uniquadric
