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
  const int height = scene.camera.height;
  const int bands = imaging.rolling_shutter_s > 0 ? std::min(imaging.rolling_shutter_bands, height) : 1;
  const int exposures = imaging.exposure_s > 0 ? imaging.exposure_steps : 1;
  std::vector<ColorStep> steps;
  for (int band = 0; band < bands; ++band) {
    const int first = height * band / bands, end = height * (band + 1) / bands;
    const double middle_s = time_s + imaging.rolling_shutter_s * ((first + end) / 2.0 / height - 0.5);
    for (int i = 0; i < exposures; ++i)
      steps.push_back({poses_at(scene, middle_s + imaging.exposure_s * ((i + 0.5) / exposures - 0.5)), first,
                       end - first});
  }
  return steps;
}

double ObjectView::visible_fraction() const {
  return silhouette_px > 0 ? static_cast<double>(visible_px) / static_cast<double>(silhouette_px) : 0;
}

}  // namespace uniquadric
