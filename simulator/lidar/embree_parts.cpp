#include "simulator/lidar/embree_parts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

#include "core/base/error.h"
#include "simulator/lidar/reflectivity.h"

namespace uniquadric {
namespace {

// Embree itself takes an unknown or missing instruction set for another without a word.
bool machine_has(const std::string& isa) {
  if (isa == "sse2") return true;
  if (isa == "sse4.2") return __builtin_cpu_supports("sse4.2");
  if (isa == "avx") return __builtin_cpu_supports("avx");
  if (isa == "avx2") return __builtin_cpu_supports("avx2");
  return isa == "avx512" && __builtin_cpu_supports("avx512vl");
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

}  // namespace

void check_embree(RTCDevice device, const char* doing) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE)
    throw std::runtime_error(fmt::format("lidar: Embree error {} while {}", static_cast<int>(error), doing));
}

Device make_device(const std::string& isa) {
  if (!machine_has(isa))
    throw InputError(fmt::format("lidar: this machine has no instruction set '{}' (isa)", isa));
  Device device(rtcNewDevice(fmt::format("isa={}", isa).c_str()));
  check_embree(device.get(), "starting");
  return device;
}

EmbreeScene new_scene(RTCDevice device) {
  EmbreeScene scene(rtcNewScene(device));
  rtcSetSceneFlags(scene.get(), RTC_SCENE_FLAG_ROBUST);  // or rays leak through shared edges
  return scene;
}

void add_meshes(RTCDevice device, Part& part, const Body& body, const Pose& place, float reflectivity) {
  for (const Mesh& mesh : body.meshes) {
    if (mesh.triangles.empty()) continue;
    attach_mesh(device, part.scene.get(), mesh, place);
    part.reflectivity.push_back(reflectivity >= 0 ? reflectivity : mean_luminance(mesh));
    for (const Eigen::Vector3f& p : mesh.positions)
      part.radius_m = std::max(part.radius_m, p.cast<double>().norm());
  }
}

}  // namespace uniquadric
