#pragma once

// What the files that call Embree share; for them alone.
#include <memory>
#include <string>
#include <vector>

#include "core/embree/embree.h"
#include "core/embree/rtcore_parts.h"
#include "simulator/lidar/ray_caster.h"

namespace uniquadric {

/// A device of one instruction set. Throws InputError when the machine has it not.
EmbreeDevice make_device(const std::string& isa);

/// An empty scene in which no ray leaks through shared edges.
EmbreeScene new_scene(RTCDevice device);

/// One instance of the top level: the whole static world, or an object.
struct Part {
  std::uint16_t id = 0;
  Motion motion = {};
  EmbreeScene scene;
  double radius_m = 0;                   ///< of the farthest vertex from the origin
  std::vector<float> reflectivity = {};  ///< one a mesh
};

/// Adds a body's meshes, its frame standing at `place`. `reflectivity` below 0: that of each mesh's colours.
void add_meshes(RTCDevice device, Part& part, const Body& body, const Pose& place, float reflectivity);

/// object_from_world's rotations at the keys of a scan, for normals.
struct Rotations {
  std::vector<Eigen::Matrix3f> object_from_world;

  /// Linear between keys: these lie so close, or turn so evenly, that the cosine's error is that of a chord.
  Eigen::Vector3f to_object(const Eigen::Vector3f& direction, float time) const {
    if (object_from_world.size() == 1) return object_from_world[0] * direction;
    const float place = time * static_cast<float>(object_from_world.size() - 1);
    const std::size_t before = std::min(static_cast<std::size_t>(place), object_from_world.size() - 2);
    const float u = place - static_cast<float>(before);
    return (1 - u) * (object_from_world[before] * direction) +
           u * (object_from_world[before + 1] * direction);
  }
};

struct CasterScan::State {
  std::shared_ptr<const void> owner;  ///< of the meshes
  EmbreeScene scene;
  std::vector<const Part*> parts;
  std::vector<Rotations> rotations;
  std::vector<MotionKeys> keys;
};

}  // namespace uniquadric
