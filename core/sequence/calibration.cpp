#include "core/sequence/calibration.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "core/base/config.h"
#include "core/base/files.h"
#include "core/sequence/image_file.h"

namespace uniquadric {

namespace {
int image_side(const ConfigNode& node, const std::string& key) {
  const int side = node.get<int>(key);
  require_image_side(node.at(key), side);
  return side;
}

double principal_point(const ConfigNode& node, const std::string& key, int side_px) {
  const double place = node.get<double>(key);
  require_principal_point(node.at(key), place, side_px);
  return place;
}

double focal_length(const ConfigNode& node, const std::string& key, int side_px) {
  const double focal = node.positive(key);
  require_focal_length(node.at(key), focal, side_px);
  return focal;
}
}  // namespace

void require_image_side(const ConfigNode& node, int side_px) {
  if (side_px < 1 || side_px > kMostImageSide_px)
    node.fail(fmt::format("expected 1 to {} px, found {}", kMostImageSide_px, side_px));
}

// A hundredth of the image's side: 89 degrees to each side; a thousand of it: a minute of arc.
void require_focal_length(const ConfigNode& node, double focal_px, int side_px) {
  if (!(focal_px >= 0.01 * side_px && focal_px <= 1000.0 * side_px))
    node.fail(fmt::format("expected {} to {} px, found {}", 0.01 * side_px, 1000 * side_px, focal_px));
}

// A cut-out or a shifted lens has it outside the image, but not by far.
void require_principal_point(const ConfigNode& node, double place_px, int side_px) {
  const double most = 10.0 * side_px;
  if (!(std::abs(place_px) <= most))
    node.fail(fmt::format("expected {} to {} px, found {}", -most, most, place_px));
}

Camera read_camera(const ConfigNode& node) {
  Camera camera;
  camera.width = image_side(node, "width");
  camera.height = image_side(node, "height");
  camera.fx = focal_length(node, "fx", camera.width);
  camera.fy = focal_length(node, "fy", camera.height);
  camera.cx = principal_point(node, "cx", camera.width);
  camera.cy = principal_point(node, "cy", camera.height);
  if (const auto distortion = node.find("distortion")) {
    const auto values = distortion->as<std::vector<double>>();
    if (values.size() != camera.distortion.size())
      distortion->fail(fmt::format("expected 5 numbers k1, k2, p1, p2, k3, found {}", values.size()));
    std::copy(values.begin(), values.end(), camera.distortion.begin());
  }
  return camera;
}

std::string camera_yaml(const Camera& camera) {
  return fmt::format("width: {}, height: {}, fx: {}, fy: {}, cx: {}, cy: {}, distortion: [{}]", camera.width,
                     camera.height, camera.fx, camera.fy, camera.cx, camera.cy,
                     fmt::join(camera.distortion, ", "));
}

Pose read_extrinsics(const ConfigNode& node) {
  constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm, as in trajectories
  Pose pose;
  pose.translation = node.get<Eigen::Vector3d>("position_m");
  const auto q = node.get<std::vector<double>>("quaternion_xyzw");
  if (q.size() != 4)
    node.at("quaternion_xyzw").fail(fmt::format("expected 4 numbers x, y, z, w, found {}", q.size()));
  pose.rotation = Eigen::Quaterniond(q[3], q[0], q[1], q[2]);
  const double norm = pose.rotation.norm();
  if (std::abs(norm - 1) > kUnitTolerance)
    node.at("quaternion_xyzw").fail(fmt::format("norm is {:.6g}, expected 1", norm));
  node.refuse_unknown_keys();
  return pose;
}

std::string extrinsics_yaml(const Pose& pose) {
  return fmt::format("{{position_m: [{}], quaternion_xyzw: [{}]}}", fmt::join(pose.translation, ", "),
                     fmt::join(pose.rotation.coeffs(), ", "));
}

Camera read_camera_yaml(const std::filesystem::path& path) {
  const ConfigNode node = ConfigNode::load(path);
  const Camera camera = read_camera(node);
  node.refuse_unknown_keys();
  return camera;
}

void write_camera_yaml(const std::filesystem::path& path, const Camera& camera) {
  write_text(path, "{" + camera_yaml(camera) + "}\n");
}

}  // namespace uniquadric
