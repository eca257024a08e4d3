#include "simulator/scene/pose_reader.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/base/error.h"
#include "simulator/scene/bounds.h"
#include "simulator/scene/named_motions.h"

namespace uniquadric {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kUnitTolerance = 1e-3;  // of a quaternion's norm, as for trajectories that are read
constexpr double kRadians = std::numbers::pi / 180;

Quaterniond read_quaternion(const ConfigNode& node) {
  const auto q = node.as<std::vector<double>>();
  if (q.size() != 4) node.fail(fmt::format("expected 4 numbers x, y, z, w, found {}", q.size()));
  const Quaterniond rotation(q[3], q[0], q[1], q[2]);
  if (std::abs(rotation.norm() - 1) > kUnitTolerance)
    node.fail(fmt::format("norm is {:.6g}, expected 1", rotation.norm()));
  return rotation.normalized();
}

}  // namespace

Quaterniond read_rpy_deg(const ConfigNode& node) {
  const Vector3d rpy = node.as<Vector3d>() * kRadians;
  return (exp_so3(rpy.z() * Vector3d::UnitZ()) * exp_so3(rpy.y() * Vector3d::UnitY()) *
          exp_so3(rpy.x() * Vector3d::UnitX()))
      .normalized();
}

Quaterniond read_orientation(const ConfigNode& node, Mover mover, const Vector3d& position_m,
                             const std::optional<ConfigNode>& target) {
  const auto rpy = node.find("rpy_deg"), quaternion = node.find("quaternion_xyzw"),
             own_target = node.find("look_at_m");
  if (rpy.has_value() + quaternion.has_value() + own_target.has_value() > 1)
    node.fail("give one of rpy_deg, quaternion_xyzw, look_at_m");
  const auto roll = node.find("roll_deg");
  if (roll && (rpy || quaternion || !(own_target || target))) roll->fail("belongs to look_at_m");
  if (rpy) return read_rpy_deg(*rpy);
  if (quaternion) return read_quaternion(*quaternion);
  const auto& looked_at = own_target ? own_target : target;
  if (!looked_at) return Quaterniond::Identity();
  if (mover != Mover::camera) looked_at->fail("is for cameras; give rpy_deg or quaternion_xyzw");
  try {
    return look_at(position_m, looked_at->as<Vector3d>(), roll ? roll->as<double>() * kRadians : 0).rotation;
  } catch (const InputError& error) {
    node.fail(error.what());
  }
}

Pose read_pose(const ConfigNode& node, Mover mover) {
  const auto position = node.get<Vector3d>("position_m", Vector3d::Zero());
  return {read_orientation(node, mover, position), position};
}

namespace {

Pose read_mounted(const ConfigNode& node) {
  read_within(node, "position_m", Vector3d::Zero(), kMostOffset_m);
  read_within(node, "rpy_deg", Vector3d::Zero(), kMostTurn_deg);
  const Pose pose = read_pose(node, Mover::body);
  node.refuse_unknown_keys();
  return pose;
}

}  // namespace

Pose camera_from_body_axes() {
  return {Quaterniond(0.5, 0.5, -0.5, 0.5), Vector3d::Zero()};  // x -> z, y -> -x, z -> -y
}

Pose read_mounting(const ConfigNode& node, const std::string& sensor) {
  const auto in_camera = node.find("camera_from_" + sensor), in_body = node.find("body_from_" + sensor);
  if (in_camera && in_body) in_body->fail(fmt::format("give one of camera_from_{0}, body_from_{0}", sensor));
  if (!in_camera && !in_body) return camera_from_body_axes();
  const Pose pose = read_mounted(in_camera ? *in_camera : *in_body);
  return in_camera ? pose : camera_from_body_axes() * pose;
}

Pose read_mounting_error(const ConfigNode& node) {
  const auto error = node.find("mounting_error");
  return error ? read_mounted(*error) : Pose{};
}

}  // namespace uniquadric
