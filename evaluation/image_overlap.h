#pragma once

#include <cstdint>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {

/// An ellipsoid in the world and the camera that sees it.
struct ObservedEllipsoid {
  Pose world_from_camera;
  Ellipsoid ellipsoid;
};

/// 2D figures of two ellipsoids in one image; empty unless both have an elliptic outline.
struct ImageOverlap {
  ProjectionStatus truth_status = ProjectionStatus::behind, estimate_status = ProjectionStatus::behind;
  std::optional<double> rectangle_iou, ellipse_iou, box_iou;
  std::optional<double> clipped_rectangle_iou;  ///< also empty when both rectangles lie off the image
};

/// Each ellipsoid is projected through its own camera pose (true or estimated).
ImageOverlap overlap_in_image(const Camera& camera, const ObservedEllipsoid& truth,
                              const ObservedEllipsoid& estimate);

/// The pose nearest in time, nothing when it is further off than `max_difference_ns`.
const Pose* nearest_pose(const Trajectory& trajectory, std::int64_t stamp_ns, std::int64_t max_difference_ns);

}  // namespace uniquadric
