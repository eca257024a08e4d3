#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "simulator/lidar/lidar_scan.h"

namespace uniquadric {

/// What a depth image shows, as an octree of occupied cells: the paper's way to a LiDAR.
class DepthOctree {
 public:
  /// `depth_m`: CV_32FC1, z along the optical axis [m], 0 where nothing is, of `camera`'s size. Cells have
  /// edges of `resolution_m`; pixels farther than `max_range_m` are left out. Throws InputError when sizes
  /// differ.
  DepthOctree(const cv::Mat& depth_m, const Camera& camera, const Pose& lidar_from_camera,
              double resolution_m, double max_range_m);
  DepthOctree(DepthOctree&&) noexcept;
  ~DepthOctree();

  /// Range [m] along a unit direction from `origin` (lidar frame) to where the ray enters the first occupied
  /// cell; nothing when there is none within the greatest range.
  std::optional<double> cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// A camera (no distortion, optical frame) at the lidar's origin that looks along its x and sees at least
/// +-horizontal_deg / 2 and +-vertical_deg / 2, `width_px` wide; below 180 deg.
Camera camera_of_field(double horizontal_deg, double vertical_deg, int width_px);

/// The paper's route to a scan: everything stands where the depth image has it, only the sensor's directions
/// are a LiDAR's. Points carry the noise-free range; the truth's instance is 0 (a depth image does not say).
LidarScan take_octree_scan(const DepthOctree& octree, const LidarRig& rig, std::int64_t scan);

/// Ranges of one route against those of another over the same beams.
struct RangeComparison {
  std::int64_t beams = 0;    ///< that either route has a range for
  std::int64_t matched = 0;  ///< both have
  std::int64_t lost = 0;     ///< only the reference has
  std::int64_t extra = 0;    ///< only the compared route has
  double mean_m = 0;         ///< of compared minus reference; all of the errors over matched beams
  double median_abs_m = 0, p95_abs_m = 0, rms_m = 0;
  std::vector<std::int64_t>
      histogram;  ///< of errors, cells of `cell_m` around 0; the outer two take the rest

  double completeness() const;  ///< matched over the reference's; 1 when that has none
};

/// Matches points by offset and ring; both scans must be of the same pattern and start.
RangeComparison compare_ranges(const LidarScan& compared, const LidarScan& reference, double cell_m = 0.01,
                               int cells = 101);

}  // namespace uniquadric
