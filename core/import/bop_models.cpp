#include "core/import/bop_models.h"

#include <limits>

#include "core/base/config.h"
#include "core/import/fields.h"
#include "core/sequence/estimated_objects.h"

namespace uniquadric {
namespace {

Eigen::Vector3d read_xyz_m(const ConfigNode& node, const std::string& prefix) {
  const auto read = [&](const char* axis) { return node.get<double>(prefix + axis) / kBopMmPerM; };
  return {read("x"), read("y"), read("z")};
}

BopModel read_model(const ConfigNode& node) {
  BopModel model;
  model.semi_axes_m = read_xyz_m(node, "size_") / 2;
  if (const std::string fault = semi_axes_fault(model.semi_axes_m); !fault.empty())
    node.fail("size_x, size_y, size_z: " + fault);
  model.center_m = read_xyz_m(node, "min_") + model.semi_axes_m;
  return model;
}

}  // namespace

std::map<int, BopModel> read_bop_models(const std::filesystem::path& file) {
  std::map<int, BopModel> models;
  for (const auto& [key, node] : ConfigNode::load(file).entries())
    models[static_cast<int>(read_count(file, node.line(), key, "object", std::numeric_limits<int>::max()))] =
        read_model(node);
  return models;
}

}  // namespace uniquadric
