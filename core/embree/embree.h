#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;
struct RTCGeometryTy;

namespace uniquadric {

struct EmbreeRelease {
  void operator()(RTCDeviceTy* device) const;
  void operator()(RTCSceneTy* scene) const;
  void operator()(RTCGeometryTy* geometry) const;
};
using EmbreeDevice = std::unique_ptr<RTCDeviceTy, EmbreeRelease>;
using EmbreeScene = std::unique_ptr<RTCSceneTy, EmbreeRelease>;
using EmbreeGeometry = std::unique_ptr<RTCGeometryTy, EmbreeRelease>;

// Embree throws nothing: it returns null and notes an error of the device. All of these throw
// std::runtime_error that says what Embree was doing, and whether memory ran out.

/// Throws when Embree noted an error. `device` may be null: then the error is of the thread.
void check_embree(RTCDeviceTy* device, const char* doing);
/// As check_embree, and when `made` is null.
void require_embree(RTCDeviceTy* device, const void* made, const char* doing);

/// `config` as rtcNewDevice takes it, such as isa=avx2; may be empty.
EmbreeDevice new_embree_device(const std::string& config);
EmbreeScene new_embree_scene(RTCDeviceTy* device);
/// Adds triangles of indices into `corners`, and copies both.
void attach_triangles(RTCDeviceTy* device, RTCSceneTy* scene, const std::vector<Eigen::Vector3f>& corners,
                      const std::vector<std::array<std::uint32_t, 3>>& triangles);
/// A scene that fails is left unreleased: Embree ends the program where it releases one whose threads failed.
void commit_embree_scene(RTCDeviceTy* device, EmbreeScene& scene);

}  // namespace uniquadric
