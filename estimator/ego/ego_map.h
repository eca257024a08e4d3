#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// A frame whose pose and sightings are kept for optimisation.
struct Keyframe {
  std::int64_t frame = 0;
  Pose camera_from_world;
  std::vector<Feature> features;  ///< sightings of points of the map
};

/// A point of the background.
struct MapPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();  ///< world [m]
  std::vector<int> keyframes;                          ///< that see it, in their order
};

/// What the odometry knows of the world, whose frame is that of the first camera.
struct EgoMap {
  std::vector<Keyframe> keyframes;
  std::map<std::int64_t, MapPoint> points;  ///< by the features' track ids
};

/// Adds a keyframe: sightings of known points that lie in its features, and new points where features have
/// depth.
void add_keyframe(EgoMap& map, const Camera& camera, Keyframe keyframe);

/// Takes a keyframe's sightings of points out of the map; points that no keyframe sees any more go.
void remove_sightings(EgoMap& map, int keyframe, const std::vector<std::int64_t>& tracks);

}  // namespace uniquadric
