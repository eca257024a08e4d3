#include "simulator/scene/shape_reader.h"

#include <fmt/format.h>

#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>
#include <string>

#include "core/base/config.h"
#include "simulator/scene/shapes.h"

namespace uniquadric {
namespace {

constexpr double kLeastStreet_m[] = {40, 28, 5};  // room for its houses, pavements and a lane
constexpr int kMaxSegments = 512, kMaxFurniture = 100, kMinTexture_px = 16, kMaxTexture_px = 4096,
              kMaxMarks = 200;

int integer(const ConfigNode& node, const std::string& key, int fallback, int low, int high) {
  const int value = node.get<int>(key, fallback);
  if (value < low || value > high)
    node.at(key).fail(fmt::format("expected {} to {}, found {}", low, high, value));
  return value;
}

Eigen::Vector3d color(const ConfigNode& node, const std::string& key, const Eigen::Vector3d& fallback) {
  const auto value = node.get<Eigen::Vector3d>(key, fallback);
  if (value.minCoeff() < 0 || value.maxCoeff() > 1)
    node.at(key).fail("expected red, green, blue from 0 to 1");
  return value;
}

Material read_material(const ConfigNode& body, const MaterialDefaults& defaults,
                       const std::string& primitive) {
  Material material;
  material.seed = defaults.seed;
  material.amount = defaults.amount;
  material.is_painted = defaults.is_painted;
  if (primitive == "room" || primitive == "street" || primitive == "car" ||
      primitive == "carriage") {  // seen from nearer than their size
    material.size_px = 1024;
    material.marks = primitive == "carriage" ? 40 : 24;
  }
  const auto node = body.find("material");
  if (!node) return material;
  const std::vector<std::string> styles(kTextureStyleNames.begin(), kTextureStyleNames.end());
  const std::string style = node->choice("style", styles, styles.front());
  material.style = static_cast<TextureStyle>(std::find(styles.begin(), styles.end(), style) - styles.begin());
  material.color = color(*node, "color", material.color);
  material.accent = color(*node, "accent", material.accent);
  material.amount = read_texture_amount(*node, material.amount);
  material.contrast = read_share(*node, "contrast", material.contrast);
  material.seed = node->get<std::uint64_t>("seed", material.seed);
  material.size_px = integer(*node, "texture_px", material.size_px, kMinTexture_px, kMaxTexture_px);
  material.marks = integer(*node, "marks", material.marks, 1, kMaxMarks);
  material.shine = read_share(*node, "shine", material.shine);
  material.depth_return = read_share(*node, "depth_return", material.depth_return);
  node->refuse_unknown_keys();
  return material;
}

Eigen::Vector3d read_size(const ConfigNode& node, const std::string& primitive) {
  const ConfigNode size = node.at("size_m");
  auto values = size.as<std::vector<double>>();
  const std::size_t expected = primitive == "plane" ? 2 : 3;
  if (values.size() != expected)
    size.fail(fmt::format("expected {} numbers, found {}", expected, values.size()));
  if (primitive == "street")
    for (int k = 0; k < 3; ++k)
      if (values[k] < kLeastStreet_m[k])
        size.fail(fmt::format("a street measures at least {} m", fmt::join(kLeastStreet_m, " x ")));
  for (const double value : values)
    if (value <= 0 || value > kLargestBody_m)
      size.fail(fmt::format("extents must be above 0 and at most {} m, found {}", kLargestBody_m, value));
  values.resize(3);
  return {values[0], values[1], values[2]};
}

RoundedBoxOptions read_rounding(const ConfigNode& node, const Eigen::Vector3d& size_m) {
  RoundedBoxOptions options;
  const double least = size_m.minCoeff();
  options.radius_m = node.get<double>("radius_m", 0.05 * least);
  if (options.radius_m < 0 || options.radius_m > least / 2)
    node.at("radius_m").fail(fmt::format("expected 0 to half the least extent, {}", least / 2));
  options.recess_depth_m = node.get<double>("recess_depth_m", 0);
  if (options.recess_depth_m < 0 || options.recess_depth_m >= least / 2)
    node.at("recess_depth_m").fail(fmt::format("expected 0 to below half the least extent, {}", least / 2));
  options.recess_share = read_share(node, "recess_share", options.recess_share);
  options.segments = integer(node, "segments", options.segments, 1, kMaxSegments);
  return options;
}

TrackOptions read_track(const ConfigNode& node) {
  if (const auto size = node.find("size_m")) size->fail("a track is measured by radius_m and its angles");
  constexpr double kRadians = std::numbers::pi / 180;
  TrackOptions options;
  options.radius_m = node.positive("radius_m");
  options.gauge_m = node.positive("gauge_m", options.gauge_m);
  options.from_rad = node.get<double>("from_deg") * kRadians;
  options.to_rad = node.get<double>("to_deg") * kRadians;
  if (options.radius_m > kLargestBody_m)
    node.at("radius_m").fail(fmt::format("expected at most {} m", kLargestBody_m));
  if (options.gauge_m > options.radius_m) node.at("gauge_m").fail("is wider than the radius");
  if (!(options.to_rad > options.from_rad) || options.to_rad - options.from_rad > 2 * std::numbers::pi)
    node.at("to_deg").fail("expected more than from_deg, by a turn at most");
  return options;
}

std::vector<Mesh> build(const ConfigNode& node, const SceneShape& shape, const Material& material) {
  const std::string& name = shape.name;
  const Eigen::Vector3d& size_m = shape.size_m;
  if (name == "box") return rounded_box(size_m, {.radius_m = 0}, material);
  if (name == "rounded_box") return rounded_box(size_m, read_rounding(node, size_m), material);
  if (name == "ball" && size_m.maxCoeff() != size_m.minCoeff())
    node.at("size_m").fail("a ball has three equal extents; use 'ellipsoid'");
  if (name == "ball" || name == "ellipsoid")
    return ellipsoid(size_m, integer(node, "segments", 20, 2, kMaxSegments), material);
  if (name == "cylinder") {
    const int segments = integer(node, "segments", 96, 4, kMaxSegments);
    if (segments % 4 != 0) node.at("segments").fail("expected a multiple of 4, so that the extents are met");
    return cylinder(size_m, segments, material);
  }
  if (name == "skateboard") return skateboard(size_m, material);
  if (name == "car") return car(size_m, material);
  if (name == "carriage") return carriage(size_m, material);
  if (name == "mug") return mug(size_m, material);
  if (name == "bowl") return bowl(size_m, material);
  if (name == "angle") {
    const double thickness = read_share(node, "thickness", 0.3);
    if (thickness <= 0 || thickness >= 1) node.at("thickness").fail("expected more than 0, less than 1");
    return angle(size_m, thickness, material);
  }
  if (name == "pedestrian") return pedestrian(size_m, material);
  if (name == "cyclist") return cyclist(size_m, material);
  if (name == "plane") return plane(size_m.head<2>(), material);
  if (name == "street") return street(size_m, node.get<bool>("parked_cars", true), material);
  return room(size_m, integer(node, "furniture", 6, 0, kMaxFurniture), material);
}

}  // namespace

TextureAmount read_texture_amount(const ConfigNode& node, TextureAmount fallback) {
  const auto value = node.find("texture");
  if (!value) return fallback;
  const std::string amount = node.choice("texture", {"rich", "sparse", "none"}, "");
  return amount == "rich"     ? TextureAmount::rich
         : amount == "sparse" ? TextureAmount::sparse
                              : TextureAmount::none;
}

double read_share(const ConfigNode& node, const std::string& key, double fallback) {
  const double value = node.get<double>(key, fallback);
  if (value < 0 || value > 1) node.at(key).fail(fmt::format("expected 0 to 1, found {}", value));
  return value;
}

SceneShape read_shape(const ConfigNode& node, const MaterialDefaults& defaults) {
  SceneShape shape;
  shape.name =
      node.choice("primitive",
                  {"box", "rounded_box", "ball", "ellipsoid", "cylinder", "skateboard", "car", "carriage",
                   "mug", "bowl", "angle", "pedestrian", "cyclist", "plane", "room", "street", "track"},
                  "");
  if (shape.name.empty()) node.fail("missing key 'primitive' (or 'mesh')");
  const Material material = read_material(node, defaults, shape.name);
  if (shape.name != "track") shape.size_m = read_size(node, shape.name);
  shape.meshes = shape.name == "track" ? track(read_track(node), material) : build(node, shape, material);
  for (Mesh& mesh : shape.meshes) {
    mesh.shine = static_cast<float>(material.shine);
    mesh.depth_return = static_cast<float>(material.depth_return);
  }
  return shape;
}

}  // namespace uniquadric
