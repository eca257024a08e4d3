#include "simulator/scene/body_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "core/base/config.h"
#include "core/base/error.h"
#include "simulator/scene/mesh_building.h"
#include "simulator/scene/mesh_import.h"
#include "simulator/scene/motion_reader.h"
#include "simulator/scene/named_motions.h"
#include "simulator/scene/path_reader.h"
#include "simulator/scene/shape_reader.h"

namespace uniquadric {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxId = 65535;  // instance images are 16-bit, 0 is background

void place(Body& body, const Pose& object_from_mesh) {
  transform(body.meshes, object_from_mesh);
  const Eigen::AlignedBox3d box = tight_box(body.meshes);
  transform(body.meshes, {Eigen::Quaterniond::Identity(), -box.center()});
  body.semi_axes_m = box.sizes() / 2;
}

void read_mesh_file(const ConfigNode& node, const ConfigNode& mesh, Body& body,
                    std::vector<fs::path>& files) {
  for (const char* key : {"primitive", "size_m", "material"})
    if (const auto other = node.find(key))
      other->fail("does not go with 'mesh', which has its own; a mesh is sized by 'scale'");
  ImportedMesh imported = import_mesh(find_file(mesh));
  files.insert(files.end(), imported.files.begin(), imported.files.end());
  body.shape = "mesh";
  body.mesh_file = mesh.as<std::string>();
  body.meshes = std::move(imported.meshes);
  for (Mesh& part : body.meshes)
    part.depth_return = static_cast<float>(read_share(node, "depth_return", part.depth_return));
  const double scale = node.positive("scale", 1);
  const Eigen::Vector3d size_m = tight_box(body.meshes).sizes() * scale;
  if (!(size_m.maxCoeff() <= kLargestBody_m))
    (node.has("scale") ? node.at("scale") : mesh)
        .fail(fmt::format("extents must be at most {} m, found {}", kLargestBody_m, size_m.maxCoeff()));
  fit_to_box(body.meshes, size_m);
  Pose turned;
  if (const auto rpy = node.find("mesh_rpy_deg")) turned.rotation = read_rpy_deg(*rpy);
  place(body, turned);
  if (!(body.semi_axes_m.minCoeff() > 0)) mesh.fail("is flat: an object needs an extent along every axis");
}

Body read_body(const ConfigNode& node, const MaterialDefaults& defaults, std::vector<fs::path>& files) {
  Body body;
  body.name = node.name("name");
  if (const auto mesh = node.find("mesh")) {
    read_mesh_file(node, *mesh, body, files);
  } else {
    SceneShape shape = read_shape(node, defaults);
    body.shape = std::move(shape.name);
    body.meshes = std::move(shape.meshes);
    body.semi_axes_m = shape.size_m / 2;
  }
  return body;
}

std::optional<BodySymmetry> read_symmetry(const ConfigNode& object, const Eigen::Vector3d& semi_axes_m) {
  const auto node = object.find("symmetry");
  if (!node) return std::nullopt;
  const auto symmetry = parse_body_symmetry(node->as<std::string>());
  if (!symmetry) node->fail("expected box, revolution, sphere or none");
  if (!allows(semi_axes_m, *symmetry)) node->fail("does not go with the extents: equal ones are within 5 %");
  return symmetry;
}

}  // namespace

Body read_static_body(const ConfigNode& node, const MaterialDefaults& defaults,
                      std::vector<fs::path>& files) {
  Body body = read_body(node, defaults, files);
  Pose pose;
  if (const auto given = node.find("pose")) {
    pose = read_pose(*given, Mover::body);
    given->refuse_unknown_keys();
  } else if (body.shape == "room" || body.shape == "street") {
    pose.translation.z() = body.semi_axes_m.z();  // the floor at z = 0
  }
  body.motion = static_motion(pose);
  node.refuse_unknown_keys();
  return body;
}

Body read_object(const ConfigNode& node, MaterialDefaults defaults, std::vector<fs::path>& files,
                 double end_s) {
  const int id = node.get<int>("id");
  if (id < 1 || id > kMaxId) node.at("id").fail(fmt::format("expected 1 to {}, found {}", kMaxId, id));
  defaults.seed = static_cast<std::uint64_t>(id);
  Body body = read_body(node, defaults, files);
  body.id = id;
  if (body.shape == "room" || body.shape == "street" || body.shape == "track" || body.shape == "plane")
    node.at("primitive").fail("is for the world, not for objects");
  body.symmetry = read_symmetry(node, body.semi_axes_m);
  body.is_scored = node.get<bool>("scored", true);
  body.motion = read_motion(node.at("motion"), {Mover::body, files, body.meshes, end_s});
  node.refuse_unknown_keys();
  return body;
}

}  // namespace uniquadric
