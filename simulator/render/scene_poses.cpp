#include <fmt/format.h>

#include <set>

#include "core/base/error.h"
#include "simulator/render/renderer.h"

namespace uniquadric {

void check_can_render(const Scene& scene) {
  if (scene.camera.has_distortion())
    throw InputError(fmt::format(
        "scene {}: camera.distortion: lens distortion cannot be rendered, give a camera without it",
        scene.name));
  std::set<int> ids;
  for (const Body& body : scene.objects)
    if (body.id < 1 || body.id > 65535 || !ids.insert(body.id).second)
      throw InputError(fmt::format("scene {}: object {}: id {} is taken or not in 1..65535", scene.name,
                                   body.name, body.id));
}

ScenePoses poses_at(const Scene& scene, double time_s) {
  ScenePoses poses{scene.camera_motion.at(time_s), {}};
  for (const Body& body : scene.objects) poses.world_from_object.push_back(body.motion.at(time_s));
  return poses;
}

std::vector<ScenePoses> exposure_poses(const Scene& scene, double time_s) {
  std::vector<ScenePoses> steps;
  const int count = scene.imaging.exposure_s > 0 ? scene.imaging.exposure_steps : 0;
  for (int i = 0; i < count; ++i)
    steps.push_back(poses_at(scene, time_s + scene.imaging.exposure_s * ((i + 0.5) / count - 0.5)));
  return steps;
}

double ObjectView::visible_fraction() const {
  return silhouette_px > 0 ? static_cast<double>(visible_px) / static_cast<double>(silhouette_px) : 0;
}

}  // namespace uniquadric
