#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "core/base/error.h"
#include "simulator/render/lens.h"
#include "simulator/render/renderer.h"

namespace uniquadric {

void check_can_render(const Scene& scene) {
  if (scene.camera.has_distortion())
    if (const auto fault = lens_fault(scene.camera))
      throw InputError(fmt::format("scene '{}': camera.calibration.distortion: {}", scene.name, *fault));
  std::set<int> ids;
  for (const Body& body : scene.objects)
    if (body.id < 1 || body.id > 65535 || !ids.insert(body.id).second)
      throw InputError(fmt::format("scene '{}': object {}: id {} is taken or not in 1..65535", scene.name,
                                   body.name, body.id));
}

ScenePoses poses_at(const Scene& scene, double time_s) {
  ScenePoses poses{scene.camera_motion.at(time_s), {}};
  for (const Body& body : scene.objects) poses.world_from_object.push_back(body.motion.at(time_s));
  return poses;
}

std::vector<ColorStep> color_steps(const Scene& scene, double time_s) {
  const Imaging& imaging = scene.imaging;
  if (!(imaging.exposure_s > 0 || imaging.rolling_shutter_s > 0)) return {};
  const int exposures = imaging.exposure_s > 0 ? imaging.exposure_steps : 1;
  const double half_s = imaging.rolling_shutter_s / 2;
  std::vector<ColorStep> steps;
  for (int i = 0; i < exposures; ++i) {
    const double middle_s = time_s + imaging.exposure_s * ((i + 0.5) / exposures - 0.5);
    steps.push_back({poses_at(scene, middle_s), {}});
    if (half_s > 0)
      steps.back().edges = {{poses_at(scene, middle_s - half_s), poses_at(scene, middle_s + half_s)}};
  }
  return steps;
}

double ObjectView::visible_fraction() const {
  return silhouette_px > 0 ? static_cast<double>(visible_px) / static_cast<double>(silhouette_px) : 0;
}

}  // namespace uniquadric
