#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/render/gpu_mesh.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// How far some bodies reach towards the sun, seen along its light: what lies behind is in their shadow.
struct ShadowMap {
  int size_px = 0;
  unsigned texture = 0, framebuffer = 0;
  /// To coordinates in [0, 1]^3 of the texture and its depth, which is 1 nearest to the sun.
  Eigen::Matrix4d map_from_world = Eigen::Matrix4d::Identity();
};

/// The shadow maps of a scene: one of the world, drawn once, and one of the objects, drawn for each set of
/// poses. Surfaces cast a shadow where their outer side faces the sun: it shines through the ceiling of a
/// room, which is seen from inside alone. They live as long as their OpenGL context.
struct ShadowMaps {
  unsigned program = 0;
  Eigen::Quaterniond light_from_world;  ///< the light travels along -z
  ShadowMap world, objects;
};

/// Makes both maps and draws the world's. Leaves framebuffer, viewport and program changed, as do the others.
ShadowMaps make_shadow_maps(const GlFunctions& gl, const Scene& scene, const std::vector<GpuBody>& world,
                            const std::vector<Pose>& world_from_static);

void draw_object_shadows(const GlFunctions& gl, ShadowMaps& maps, const std::vector<GpuBody>& objects,
                         const std::vector<Pose>& world_from_object);

/// Lets the program in use look up both maps.
void use_shadow_maps(const GlFunctions& gl, const ShadowMaps& maps, const Pose& world_from_camera);

}  // namespace uniquadric
