#include "harness/export/kitti_label.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

constexpr double kFullyVisible = 0.9, kPartlyVisible = 0.5;  // ours: KITTI's labellers had no numbers
constexpr double kPartlyInside = 0.5;  // ours: of the box in the image; KITTI's levels have no numbers

int occlusion_level(const ObjectVisibility& visibility) {
  if (visibility.silhouette_px == 0) return 3;  // unknown: no row in visibility.csv
  return visibility.visible_fraction >= kFullyVisible    ? 0
         : visibility.visible_fraction >= kPartlyVisible ? 1
                                                         : 2;
}

// 0: wholly in the image; 1, 2: more or less than half of its box's outline is.
int truncation_level(const Camera& camera, const ObjectAtFrame& object) {
  if (!object.visibility.touches_border) return 0;
  const Eigen::Matrix<double, 3, 8> corners = box_corners(object);
  if (corners.row(2).minCoeff() <= 0) return 2;  // reaches behind the camera
  Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = -low;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Array2d pixel = (camera.matrix() * corners.col(i)).hnormalized().array();
    low = low.min(pixel);
    high = high.max(pixel);
  }
  const Eigen::Array2d last(camera.width - 0.5, camera.height - 0.5);
  const Eigen::Array2d inside = (high.min(last) - low.max(-0.5)).max(0);
  return inside.prod() >= kPartlyInside * (high - low).prod() ? 1 : 2;
}

}  // namespace

KittiBox kitti_box(const ObjectAtFrame& object) {
  const Eigen::Vector3d heading = object.camera_from_object.rotation * Eigen::Vector3d::UnitX();
  KittiBox box;
  box.rotation_y_rad = std::atan2(-heading.z(), heading.x());
  const Eigen::AngleAxisd camera_from_box(box.rotation_y_rad, Eigen::Vector3d::UnitY());
  const Eigen::Matrix<double, 3, 8> corners =
      camera_from_box.toRotationMatrix().transpose() * box_corners(object);
  const Eigen::Vector3d low = corners.rowwise().minCoeff(), high = corners.rowwise().maxCoeff();
  const Eigen::Vector3d size = high - low;
  box.length_m = size.x(), box.height_m = size.y(), box.width_m = size.z();
  box.bottom_center_m =
      camera_from_box * Eigen::Vector3d((low.x() + high.x()) / 2, high.y(), (low.z() + high.z()) / 2);
  return box;
}

std::string kitti_type(const ObjectDescription& object) {
  if (object.shape == "car") return "Car";
  if (object.shape == "carriage") return "Tram";
  return "Misc";
}

std::string kitti_label_line(const Camera& camera, std::int64_t frame, const ObjectAtFrame& object,
                             const PixelBox& mask_box) {
  const KittiBox box = kitti_box(object);
  const Eigen::Vector3d& p = box.bottom_center_m;
  // the direction that the box has to the ray towards it
  const double alpha_rad =
      std::remainder(box.rotation_y_rad - std::atan2(p.x(), p.z()), 2 * std::numbers::pi);
  return fmt::format(
      "{} {} {} {} {} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f} {:.6f}\n",
      frame, object.object->id, kitti_type(*object.object), truncation_level(camera, object),
      occlusion_level(object.visibility), alpha_rad, static_cast<double>(mask_box.u_min),
      static_cast<double>(mask_box.v_min), static_cast<double>(mask_box.u_max),
      static_cast<double>(mask_box.v_max), box.height_m, box.width_m, box.length_m, p.x(), p.y(), p.z(),
      box.rotation_y_rad);
}

}  // namespace uniquadric
