#include <embree3/rtcore.h>
#include <fmt/format.h>
#include <pmmintrin.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "core/base/error.h"
#include "simulator/lidar/ray_caster.h"
#include "simulator/lidar/reflectivity.h"

namespace uniquadric {
namespace {

constexpr int kWidth = 8;  // rays a call: measured as fast as 16 with this ISA, a quarter faster than 1

struct DeviceDeleter {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
};
struct SceneDeleter {
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
};
using Device = std::unique_ptr<RTCDeviceTy, DeviceDeleter>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, SceneDeleter>;

void check(RTCDevice device, const char* doing) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    throw std::runtime_error(fmt::format("lidar: Embree error {} while {}", static_cast<int>(error), doing));
}

// Embree itself takes an unknown or missing instruction set for another without a word.
bool machine_has(const std::string& isa) {
  if (isa == "sse2") return true;
  if (isa == "sse4.2") return __builtin_cpu_supports("sse4.2");
  if (isa == "avx") return __builtin_cpu_supports("avx");
  if (isa == "avx2") return __builtin_cpu_supports("avx2");
  return isa == "avx512" && __builtin_cpu_supports("avx512vl");
}

Device make_device(const std::string& isa) {
  if (!machine_has(isa))
    throw InputError(fmt::format("lidar: this machine has no instruction set '{}' (isa)", isa));
  Device device(rtcNewDevice(fmt::format("isa={}", isa).c_str()));
  check(device.get(), "starting");
  return device;
}

EmbreeScene new_scene(RTCDevice device) {
  EmbreeScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // or rays leak through shared edges
  return scene;
}

void attach_mesh(RTCDevice device, RTCScene scene, const Mesh& mesh, const Pose& place) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* positions = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), mesh.positions.size()));
  for (const Eigen::Vector3f& p : mesh.positions) {
    const Eigen::Vector3f placed = (place * p.cast<double>()).cast<float>();
    positions = std::copy_n(placed.data(), 3, positions);
  }
  void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                            3 * sizeof(std::uint32_t), mesh.triangles.size());
  std::memcpy(triangles, mesh.triangles.data(), mesh.triangles.size() * 3 * sizeof(std::uint32_t));
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene, geometry);
  rtcReleaseGeometry(geometry);
}

// One instance of the top level: the whole static world, or an object.
struct Part {
  std::uint16_t id = 0;
  Motion motion = {};
  EmbreeScene scene;
  double radius_m = 0;
  std::vector<float> reflectivity = {};  // one a mesh
};

void add_meshes(RTCDevice device, Part& part, const Body& body, const Pose& place, float reflectivity) {
  for (const Mesh& mesh : body.meshes) {
    if (mesh.triangles.empty()) continue;
    attach_mesh(device, part.scene.get(), mesh, place);
    part.reflectivity.push_back(reflectivity >= 0 ? reflectivity : mean_luminance(mesh));
    for (const Eigen::Vector3f& p : mesh.positions)
      part.radius_m = std::max(part.radius_m, p.cast<double>().norm());
  }
}

RTCQuaternionDecomposition decomposition(const Pose& pose, const Eigen::Vector3d& origin) {
  RTCQuaternionDecomposition result;
  rtcInitQuaternionDecomposition(&result);
  const Eigen::Vector4f q = pose.rotation.coeffs().cast<float>();
  const Eigen::Vector3f t = (pose.translation - origin).cast<float>();
  rtcQuaternionDecompositionSetQuaternion(&result, q.w(), q.x(), q.y(), q.z());
  rtcQuaternionDecompositionSetTranslation(&result, t.x(), t.y(), t.z());
  return result;
}

// Subnormal numbers count as zero while this lives, as Embree wants it.
class FlushSubnormals {
 public:
  FlushSubnormals() : saved_(_mm_getcsr()) { _mm_setcsr(saved_ | _MM_FLUSH_ZERO_ON | _MM_DENORMALS_ZERO_ON); }
  ~FlushSubnormals() { _mm_setcsr(saved_); }
  FlushSubnormals(const FlushSubnormals&) = delete;
  FlushSubnormals& operator=(const FlushSubnormals&) = delete;

 private:
  unsigned saved_;
};

}  // namespace

struct RayCaster::State {
  CasterOptions options;
  Device device;
  std::vector<Part> parts;  // the world first
};

namespace {

// world_from_object's rotations at the keys of a scan, for normals.
struct Rotations {
  std::vector<Eigen::Matrix3f> object_from_world;

  // Linear between keys: these lie so close, or turn so evenly, that the cosine's error is that of a chord.
  Eigen::Vector3f to_object(const Eigen::Vector3f& direction, float time) const {
    if (object_from_world.size() == 1) return object_from_world[0] * direction;
    const float place = time * static_cast<float>(object_from_world.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(place), object_from_world.size() - 2);
    const float u = place - static_cast<float>(before);
    return (1 - u) * (object_from_world[before] * direction) +
           u * (object_from_world[before + 1] * direction);
  }
};

}  // namespace

struct CasterScan::State {
  std::shared_ptr<const void> owner;  // of the meshes
  EmbreeScene scene;
  std::vector<const Part*> parts;
  std::vector<Rotations> rotations;
  std::vector<MotionKeys> keys;
};

namespace {

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
  RTCGeometry instance = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
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
  rtcReleaseGeometry(instance);
  scan.parts.push_back(&part);
  scan.rotations.push_back(std::move(rotations));
  scan.keys.push_back(keys);
}

void load(const RayBlock& rays, int first, RTCRayHit8& packet) {
  const auto row = [&](const RayBlock::Row<float>& from, float* to) {
    std::memcpy(to, from.data() + first, kWidth * sizeof(float));
  };
  row(rays.origin_x, packet.ray.org_x);
  row(rays.origin_y, packet.ray.org_y);
  row(rays.origin_z, packet.ray.org_z);
  row(rays.x, packet.ray.dir_x);
  row(rays.y, packet.ray.dir_y);
  row(rays.z, packet.ray.dir_z);
  row(rays.time, packet.ray.time);
  for (int lane = 0; lane < kWidth; ++lane) {
    packet.ray.tnear[lane] = 0;
    packet.ray.tfar[lane] = std::numeric_limits<float>::infinity();
    packet.ray.mask[lane] = ~0u;
    packet.ray.flags[lane] = 0;
    packet.hit.geomID[lane] = RTC_INVALID_GEOMETRY_ID;
    packet.hit.instID[0][lane] = RTC_INVALID_GEOMETRY_ID;
  }
}

void store(const CasterScan::State& scan, const RTCRayHit8& packet, int lane, RayBlock& rays, int i) {
  if (packet.hit.geomID[lane] == RTC_INVALID_GEOMETRY_ID) {
    rays.distance[i] = -1;
    return;
  }
  const unsigned instance = packet.hit.instID[0][lane];
  const Part& part = *scan.parts[instance];
  const Eigen::Vector3f normal(packet.hit.Ng_x[lane], packet.hit.Ng_y[lane], packet.hit.Ng_z[lane]);
  const Eigen::Vector3f direction =
      scan.rotations[instance].to_object({rays.x[i], rays.y[i], rays.z[i]}, rays.time[i]);
  const float length2 = normal.squaredNorm() * direction.squaredNorm();
  rays.distance[i] = packet.ray.tfar[lane];
  rays.incidence_cos[i] = std::min(1.0f, std::abs(normal.dot(direction)) / std::sqrt(length2));
  rays.reflectivity[i] = part.reflectivity[packet.hit.geomID[lane]];
  rays.instance[i] = part.id;
}

}  // namespace

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
  for (const Part& part : state->parts) rtcCommitScene(part.scene.get());
  check(device, "building the meshes' hierarchies");
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
  rtcCommitScene(scan->scene.get());
  check(device, "placing the bodies");
  return CasterScan(std::move(scan));
}

CasterScan::CasterScan(std::unique_ptr<State> state) : state_(std::move(state)) {}
CasterScan::CasterScan(CasterScan&&) noexcept = default;
CasterScan::~CasterScan() = default;

std::vector<MotionKeys> CasterScan::motion_keys() const {
  return {state_->keys.begin() + 1, state_->keys.end()};
}

void CasterScan::cast(RayBlock& rays) const {
  const FlushSubnormals flush;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags =
      RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;  // measured a quarter faster, though beams are neighbours
  alignas(32) std::array<int, kWidth> valid;
  RTCRayHit8 packet;
  for (int first = 0; first < rays.count; first += kWidth) {
    load(rays, first, packet);
    for (int lane = 0; lane < kWidth; ++lane) valid[lane] = first + lane < rays.count ? -1 : 0;
    rtcIntersect8(valid.data(), state_->scene.get(), &context, &packet);
    const int lanes = std::min(kWidth, rays.count - first);
    for (int lane = 0; lane < lanes; ++lane) store(*state_, packet, lane, rays, first + lane);
  }
}

}  // namespace uniquadric
