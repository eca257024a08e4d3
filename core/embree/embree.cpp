#include "core/embree/embree.h"

#include <fmt/format.h>

#include <cstring>
#include <new>
#include <stdexcept>

#include "core/embree/rtcore_parts.h"

namespace uniquadric {
namespace {

[[noreturn]] void fail(RTCError error, const char* doing) {
  if (error == RTC_ERROR_OUT_OF_MEMORY) throw std::bad_alloc();
  throw std::runtime_error(fmt::format("Embree: error {} while {}", static_cast<int>(error), doing));
}

// A copy of `items` in a buffer of the geometry's.
template <typename Item>
void set_buffer(RTCDevice device, RTCGeometry geometry, RTCBufferType type, RTCFormat format,
                const std::vector<Item>& items) {
  void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size());
  require_embree(device, buffer, "making a buffer of a mesh");
  std::memcpy(buffer, items.data(), items.size() * sizeof(Item));
}

}  // namespace

void EmbreeRelease::operator()(RTCDeviceTy* device) const {
  rtcReleaseDevice(device);
}
void EmbreeRelease::operator()(RTCSceneTy* scene) const {
  rtcReleaseScene(scene);
}
void EmbreeRelease::operator()(RTCGeometryTy* geometry) const {
  rtcReleaseGeometry(geometry);
}

void check_embree(RTCDeviceTy* device, const char* doing) {
  if (const RTCError error = rtcGetDeviceError(device); error != RTC_ERROR_NONE) fail(error, doing);
}

void require_embree(RTCDeviceTy* device, const void* made, const char* doing) {
  check_embree(device, doing);
  if (!made) fail(RTC_ERROR_OUT_OF_MEMORY, doing);
}

EmbreeDevice new_embree_device(const std::string& config) {
  EmbreeDevice device(rtcNewDevice(config.c_str()));
  require_embree(device.get(), device.get(), "starting");
  return device;
}

EmbreeScene new_embree_scene(RTCDeviceTy* device) {
  EmbreeScene scene(rtcNewScene(device));
  require_embree(device, scene.get(), "making a scene");
  return scene;
}

void attach_triangles(RTCDeviceTy* device, RTCSceneTy* scene, const std::vector<Eigen::Vector3f>& corners,
                      const std::vector<std::array<std::uint32_t, 3>>& triangles) {
  if (triangles.empty()) return;  // Embree has no empty buffers
  const EmbreeGeometry geometry(rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE));
  require_embree(device, geometry.get(), "making a mesh");
  set_buffer(device, geometry.get(), RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, corners);
  set_buffer(device, geometry.get(), RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, triangles);
  rtcCommitGeometry(geometry.get());
  rtcAttachGeometry(scene, geometry.get());
  check_embree(device, "adding a mesh to a scene");
}

void commit_embree_scene(RTCDeviceTy* device, EmbreeScene& scene) {
  rtcCommitScene(scene.get());
  const RTCError error = rtcGetDeviceError(device);
  if (error == RTC_ERROR_NONE) return;
  static_cast<void>(scene.release());
  fail(error, "building the hierarchy of a scene");
}

}  // namespace uniquadric
