#include "evaluation/image_overlap.h"

#include <algorithm>
#include <cstdlib>

#include "evaluation/iou/outline_iou.h"

namespace uniquadric {

ImageOverlap overlap_in_image(const Camera& camera, const ObservedEllipsoid& truth,
                              const ObservedEllipsoid& estimate) {
  const auto outline = [&](const ObservedEllipsoid& seen) {
    return project(camera, relative_pose(seen.world_from_camera, seen.ellipsoid.world_from_object),
                   seen.ellipsoid.semi_axes_m);
  };
  const EllipseProjection a = outline(truth), b = outline(estimate);
  ImageOverlap result{a.status, b.status, {}, {}, {}, {}};
  if (a.status != ProjectionStatus::ok || b.status != ProjectionStatus::ok) return result;
  result.rectangle_iou = rotated_rectangle_iou(a.ellipse, b.ellipse);
  result.ellipse_iou = ellipse_iou(a.ellipse, b.ellipse);
  result.box_iou = axis_aligned_box_iou(a.ellipse, b.ellipse);
  result.clipped_rectangle_iou = clipped_rectangle_iou(a.ellipse, b.ellipse, camera);
  return result;
}

const Pose* nearest_pose(const Trajectory& trajectory, std::int64_t stamp_ns,
                         std::int64_t max_difference_ns) {
  const auto earlier = [](const StampedPose& pose, std::int64_t stamp) { return pose.stamp_ns < stamp; };
  auto best = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns, earlier);
  if (best != trajectory.begin() &&
      (best == trajectory.end() || stamp_ns - (best - 1)->stamp_ns <= best->stamp_ns - stamp_ns))
    --best;
  if (best == trajectory.end() || std::abs(best->stamp_ns - stamp_ns) > max_difference_ns) return nullptr;
  return &best->pose;
}

}  // namespace uniquadric
