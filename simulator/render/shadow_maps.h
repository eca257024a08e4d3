#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/render/gpu_mesh.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// How far surfaces reach towards the sun, seen along its light: what lies behind is in their shadow.
struct ShadowMap {
  int size_px = 0;
  double texel_m = 0;
  unsigned framebuffer = 0;
  /// To texture coordinates of its layer and depth, which is 1 nearest to the sun.
  Eigen::Matrix4d map_from_world = Eigen::Matrix4d::Identity();
};

/// Bodies and where they are.
struct PlacedBodies {
  const std::vector<GpuBody>& bodies;
  const std::vector<Pose>& world_from_body;
};

/// The shadow maps of a scene, two layers of a texture: one of the world, drawn once, and a finer one of all
/// that casts a shadow on the objects and beside them, drawn for each set of poses. Surfaces cast a shadow
/// where their outer side faces the sun: it shines through the ceiling of a room, which is seen from inside
/// alone. They live as long as their OpenGL context.
struct ShadowMaps {
  unsigned program = 0, texture = 0;
  Eigen::Quaterniond light_from_world;  ///< the light travels along -z
  ShadowMap world, objects;
};

/// Makes both maps and draws the world's. Leaves framebuffer, viewport and program changed.
ShadowMaps make_shadow_maps(const GlFunctions& gl, const Scene& scene, const PlacedBodies& world);

/// Draws the objects' map. Leaves framebuffer, viewport and program changed.
void draw_object_shadows(const GlFunctions& gl, ShadowMaps& maps, const PlacedBodies& world,
                         const PlacedBodies& objects);

/// Lets the program in use look up both maps.
void use_shadow_maps(const GlFunctions& gl, const ShadowMaps& maps, const Pose& world_from_camera);

}  // namespace uniquadric
