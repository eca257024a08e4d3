#include "simulator/lidar/embree_parts.h"

#include <fmt/format.h>

#include <algorithm>

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
  std::vector<Eigen::Vector3f> placed;
  placed.reserve(mesh.positions.size());
  for (const Eigen::Vector3f& p : mesh.positions) placed.push_back((place * p.cast<double>()).cast<float>());
  attach_triangles(device, scene, placed, mesh.triangles);
}

}  // namespace

EmbreeDevice make_device(const std::string& isa) {
  if (!machine_has(isa))
    throw InputError(fmt::format("lidar: this machine has no instruction set '{}' (isa)", isa));
  return new_embree_device(fmt::format("isa={}", isa));
}

EmbreeScene new_scene(RTCDevice device) {
  EmbreeScene scene = new_embree_scene(device);
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
