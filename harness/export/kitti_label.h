#pragma once

#include <string>

#include "harness/export/export_source.h"

namespace uniquadric {

/// KITTI's box: upright in the camera frame (its height runs along the camera's y axis), turned by rotation_y
/// about it. At rotation_y 0 the length lies along the camera's x axis, the width along z.
struct KittiBox {
  double height_m = 0, width_m = 0, length_m = 0;
  Eigen::Vector3d bottom_center_m = Eigen::Vector3d::Zero();  ///< camera frame; y points down
  double rotation_y_rad = 0;                                  ///< in [-pi, pi]
};

/// The tightest such box around the object's own, headed as the object's x axis is when seen along the
/// camera's y axis. An object upright in the camera frame keeps its size; any other gets a larger box, and
/// its roll and pitch are lost.
KittiBox kitti_box(const ObjectAtFrame& object);

/// KITTI's class of an object: Car and Tram for the shapes `car` and `carriage`, else Misc.
std::string kitti_type(const ObjectDescription& object);

/// A line of label_02: frame id type truncated occluded alpha x1 y1 x2 y2 h w l x y z ry, the object's id as
/// the track's. `mask_box` [px, pixel centres] is that of what is visible of it.
std::string kitti_label_line(const Camera& camera, std::int64_t frame, const ObjectAtFrame& object,
                             const PixelBox& mask_box);

}  // namespace uniquadric
