#include "simulator/lidar/depth_octree.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/error.h"

namespace uniquadric {

struct DepthOctree::State {
  octomap::OcTree tree;
  double max_range_m;
};

DepthOctree::DepthOctree(const cv::Mat& depth_m, const Camera& camera, const Pose& lidar_from_camera,
                         double resolution_m, double max_range_m)
    : state_(new State{octomap::OcTree(resolution_m), max_range_m}) {
  if (depth_m.type() != CV_32FC1 || depth_m.cols != camera.width || depth_m.rows != camera.height)
    throw InputError(fmt::format("depth_octree: depth is {}x{}, camera says {}x{}", depth_m.cols,
                                 depth_m.rows, camera.width, camera.height));
  for (int v = 0; v < depth_m.rows; ++v)
    for (int u = 0; u < depth_m.cols; ++u) {
      const double z = depth_m.at<float>(v, u);
      if (!(z > 0)) continue;
      const auto ray = camera.unproject({u, v});
      if (!ray || (*ray * z).norm() > max_range_m) continue;
      const Eigen::Vector3d p = lidar_from_camera * (*ray * z);
      state_->tree.setNodeValue(
          octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())),
          state_->tree.getClampingThresMaxLog(), true);
    }
  state_->tree.updateInnerOccupancy();
}

DepthOctree::DepthOctree(DepthOctree&&) noexcept = default;
DepthOctree::~DepthOctree() = default;

namespace {

octomap::point3d point(const Eigen::Vector3d& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

}  // namespace

std::optional<double> DepthOctree::cast(const Eigen::Vector3d& origin,
                                        const Eigen::Vector3d& direction) const {
  octomap::point3d cell, entry;
  const octomap::point3d from = point(origin), along = point(direction);
  if (!state_->tree.castRay(from, along, cell, true, state_->max_range_m)) return std::nullopt;
  // The cell's centre is what castRay gives; the ray's entry into it is nearer to the surface.
  if (!state_->tree.getRayIntersection(from, along, cell, entry)) entry = cell;
  return static_cast<double>((entry - from).norm());
}

Camera camera_of_field(double horizontal_deg, double vertical_deg, int width_px) {
  const double half_x = std::tan(horizontal_deg * std::numbers::pi / 360);
  const double half_y = std::tan(vertical_deg * std::numbers::pi / 360);
  Camera camera;
  camera.width = width_px;
  camera.fx = camera.fy = width_px / (2 * half_x);
  camera.height = static_cast<int>(std::ceil(2 * half_y * camera.fy));
  camera.cx = (camera.width - 1) / 2.0;
  camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

LidarScan take_octree_scan(const DepthOctree& octree, const LidarRig& rig, std::int64_t scan) {
  LidarScan result;
  result.start_ns = rig.start_ns(scan);
  const std::int64_t first = rig.pattern.first_at(result.start_ns);
  result.beams = rig.pattern.first_at(rig.start_ns(scan + 1)) - first;
  BeamBlock beams;
  for (std::int64_t done = 0; done < result.beams; done += beams.count) {
    const auto count = static_cast<int>(std::min<std::int64_t>(BeamBlock::kCapacity, result.beams - done));
    rig.pattern.fill(first + done, count, beams);
    for (int i = 0; i < count; ++i) {
      const Eigen::Vector3d origin(beams.origin_x[i], beams.origin_y[i], beams.origin_z[i]);
      const Eigen::Vector3d direction(beams.x[i], beams.y[i], beams.z[i]);
      const auto range = octree.cast(origin, direction);
      if (!range) continue;
      const Eigen::Vector3f p = (origin + *range * direction).cast<float>();
      result.points.push_back({p.x(), p.y(), p.z(), 0,
                               static_cast<std::uint32_t>(beams.time_ns[i] - result.start_ns), beams.ring[i],
                               0});
      result.truth.push_back({static_cast<float>(*range), 0, 0, LidarPointTruth::Kind::surface});
    }
  }
  return result;
}

}  // namespace uniquadric
