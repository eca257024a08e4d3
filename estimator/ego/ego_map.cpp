#include "estimator/ego/ego_map.h"

#include <algorithm>

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {

void add_keyframe(EgoMap& map, const Camera& camera, Keyframe keyframe) {
  const int index = static_cast<int>(map.keyframes.size());
  const Pose world_from_camera = keyframe.camera_from_world.inverse();
  std::vector<Feature> kept;
  for (const Feature& feature : keyframe.features) {
    const auto known = map.points.find(feature.track);
    if (known == map.points.end()) {
      if (!(feature.depth_m > 0)) continue;
      const Eigen::Vector3d seen = feature.depth_m * ideal_ray(camera, feature.pixel);
      map.points[feature.track] = {world_from_camera * seen, {index}};
    } else {
      known->second.keyframes.push_back(index);
    }
    kept.push_back(feature);
  }
  keyframe.features = std::move(kept);
  map.keyframes.push_back(std::move(keyframe));
}

void remove_sightings(EgoMap& map, int keyframe, const std::vector<std::int64_t>& tracks) {
  const auto is_removed = [&](const Feature& f) {
    return std::find(tracks.begin(), tracks.end(), f.track) != tracks.end();
  };
  std::erase_if(map.keyframes[keyframe].features, is_removed);
  for (const std::int64_t track : tracks) {
    const auto point = map.points.find(track);
    if (point == map.points.end()) continue;
    std::erase(point->second.keyframes, keyframe);
    if (point->second.keyframes.empty()) map.points.erase(point);
  }
}

}  // namespace uniquadric
