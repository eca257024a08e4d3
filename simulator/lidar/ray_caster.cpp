#include "simulator/lidar/ray_caster.h"

#include <cassert>

#include "simulator/lidar/embree_parts.h"

namespace uniquadric {
namespace {

RTCQuaternionDecomposition decomposition(const Pose& pose, const Eigen::Vector3d& origin) {
  RTCQuaternionDecomposition result;
  rtcInitQuaternionDecomposition(&result);
  const Eigen::Vector4f q = pose.rotation.coeffs().cast<float>();
  const Eigen::Vector3f t = (pose.translation - origin).cast<float>();
  rtcQuaternionDecompositionSetQuaternion(&result, q.w(), q.x(), q.y(), q.z());
  rtcQuaternionDecompositionSetTranslation(&result, t.x(), t.y(), t.z());
  return result;
}

void set_key(RTCGeometry instance, int key, const Pose& pose, const Eigen::Vector3d& origin, bool slerp) {
  if (slerp) {
    const RTCQuaternionDecomposition parts = decomposition(pose, origin);
    rtcSetGeometryTransformQuaternion(instance, static_cast<unsigned>(key), &parts);
    return;
  }
  Eigen::Matrix<float, 3, 4> matrix;
  matrix << pose.rotation.toRotationMatrix().cast<float>(), (pose.translation - origin).cast<float>();
  rtcSetGeometryTransform(instance, static_cast<unsigned>(key), RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR,
                          matrix.data());
}

void attach_instance(RTCDevice device, CasterScan::State& scan, const Part& part, const MotionKeys& keys,
                     const Eigen::Vector3d& origin, double start_s, double end_s) {
  const EmbreeGeometry owned(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE));
  RTCGeometry instance = owned.get();
  require_embree(device, instance, "placing a body");
  rtcSetGeometryInstancedScene(instance, part.scene.get());
  rtcSetGeometryTimeStepCount(instance, static_cast<unsigned>(keys.count));
  Rotations rotations;
  Eigen::Quaterniond before = Eigen::Quaterniond::Identity();
  for (int k = 0; k < keys.count; ++k) {
    Pose pose =
        part.motion.at(keys.count == 1 ? start_s : start_s + (end_s - start_s) * k / (keys.count - 1));
    if (before.dot(pose.rotation) < 0) pose.rotation.coeffs() *= -1;  // the shorter way round
    before = pose.rotation;
    set_key(instance, k, pose, origin, keys.slerp);
    rotations.object_from_world.push_back(pose.rotation.conjugate().toRotationMatrix().cast<float>());
  }
  rtcCommitGeometry(instance);
  rtcAttachGeometry(scan.scene.get(), instance);
  check_embree(device, "placing a body");
  scan.parts.push_back(&part);
  scan.rotations.push_back(std::move(rotations));
  scan.keys.push_back(keys);
}

}  // namespace

struct RayCaster::State {
  CasterOptions options;
  EmbreeDevice device;
  std::vector<Part> parts;  // the world first
};

RayCaster::RayCaster(const std::vector<Body>& world, const std::vector<Body>& objects,
                     const CasterOptions& options,
                     const std::vector<std::pair<std::string, double>>& reflectivity) {
  auto state = std::make_shared<State>();
  state->options = options;
  state->device = make_device(options.isa);
  RTCDevice device = state->device.get();
  const auto named = [&](const Body& body) {
    for (const auto& [name, value] : reflectivity)
      if (name == body.name) return static_cast<float>(value);
    return -1.0f;
  };
  state->parts.push_back({.scene = new_scene(device)});
  for (const Body& body : world) add_meshes(device, state->parts[0], body, body.motion.at(0), named(body));
  for (const Body& body : objects) {
    state->parts.push_back(
        {.id = static_cast<std::uint16_t>(body.id), .motion = body.motion, .scene = new_scene(device)});
    add_meshes(device, state->parts.back(), body, {}, named(body));
  }
  for (Part& part : state->parts) commit_embree_scene(device, part.scene);
  state_ = std::move(state);
}

RayCaster::RayCaster(RayCaster&&) noexcept = default;
RayCaster::~RayCaster() = default;

CasterScan RayCaster::open(const Eigen::Vector3d& origin, std::int64_t start_ns, std::int64_t end_ns) const {
  assert(end_ns > start_ns);
  RTCDevice device = state_->device.get();
  auto scan = std::make_unique<CasterScan::State>();
  scan->owner = state_;
  scan->scene = new_scene(device);
  for (const Part& part : state_->parts) {
    MotionKeys keys =
        motion_keys_for(part.motion, start_ns, end_ns, part.radius_m, state_->options.motion_tolerance_m);
    if (keys.count > 1 && state_->options.motion_keys > 0) keys = {state_->options.motion_keys, true};
    attach_instance(device, *scan, part, keys, origin, static_cast<double>(start_ns) * 1e-9,
                    static_cast<double>(end_ns) * 1e-9);
  }
  commit_embree_scene(device, scan->scene);
  return CasterScan(std::move(scan));
}

}  // namespace uniquadric
