#include "core/import/pinhole.h"

#include <algorithm>

#include "core/base/config.h"
#include "core/sequence/calibration.h"

namespace uniquadric {
namespace {

std::vector<double> numbers(const ConfigNode& node, const std::string& key, std::size_t count,
                            const char* expected) {
  const auto values = node.get<std::vector<double>>(key);
  if (values.size() != count) node.at(key).fail(std::string("expected ") + expected);
  return values;
}

void require_sizes(const ConfigNode& width, const ConfigNode& height, const ConfigNode& fx,
                   const ConfigNode& fy, const ConfigNode& cx, const ConfigNode& cy, const Camera& camera) {
  require_image_side(width, camera.width);
  require_image_side(height, camera.height);
  require_focal_length(fx, camera.fx, camera.width);
  require_focal_length(fy, camera.fy, camera.height);
  require_principal_point(cx, camera.cx, camera.width);
  require_principal_point(cy, camera.cy, camera.height);
}

}  // namespace

Camera read_pinhole_camera(const ConfigNode& node, const std::string& coefficients) {
  node.choice("camera_model", {"pinhole"}, "pinhole");
  const auto model = node.choice("distortion_model", {"radtan", "radial-tangential", "none"}, "none");
  const auto size = node.at("resolution").items();
  if (size.size() != 2) node.at("resolution").fail("expected width and height");
  const auto k = numbers(node, "intrinsics", 4, "fx, fy, cx, cy");
  Camera camera{size[0].as<int>(), size[1].as<int>(), k[0], k[1], k[2], k[3], {}};
  const ConfigNode all = node.at("intrinsics");
  require_sizes(size[0], size[1], all, all, all, all, camera);
  if (model == "none") return camera;
  const auto d = numbers(node, coefficients, 4, "k1, k2, p1, p2");
  std::copy(d.begin(), d.end(), camera.distortion.begin());
  return camera;
}

Camera read_settings_camera(const ConfigNode& node) {
  const auto key = [](const char* name) { return std::string("Camera.") + name; };
  Camera camera{node.get<int>(key("width")),
                node.get<int>(key("height")),
                node.positive(key("fx")),
                node.positive(key("fy")),
                node.get<double>(key("cx")),
                node.get<double>(key("cy")),
                {}};
  require_sizes(node.at(key("width")), node.at(key("height")), node.at(key("fx")), node.at(key("fy")),
                node.at(key("cx")), node.at(key("cy")), camera);
  const char* const names[] = {"k1", "k2", "p1", "p2", "k3"};
  for (std::size_t i = 0; i < camera.distortion.size(); ++i)
    camera.distortion[i] = node.get<double>(key(names[i]), 0.0);
  return camera;
}

}  // namespace uniquadric
