#include "simulator/scene/scene.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/hash.h"
#include "core/base/random.h"
#include "core/base/read_file.h"
#include "core/base/warning.h"
#include "core/sequence/calibration.h"
#include "core/sequence/trajectory.h"
#include "simulator/scene/body_reader.h"
#include "simulator/scene/motion_reader.h"
#include "simulator/scene/noise_scale.h"
#include "simulator/scene/path_reader.h"
#include "simulator/scene/realism.h"
#include "simulator/scene/sensor_reader.h"

namespace uniquadric {
namespace {

namespace fs = std::filesystem;

constexpr std::int64_t kMaxFrames = 10'000'000;
constexpr double kMinRate_hz = 1e-3, kMaxRate_hz = 10'000;
constexpr double kMaxDuration_s = 1e9;  // stamps are nanoseconds in 64 bits: nine times this
constexpr std::size_t kMostMeshBytes = std::size_t{2} << 30;  // ours: forty of the largest textures
constexpr std::uint64_t kWorldSeed = 100'000;  // material seeds of the world, clear of the objects' ids

void read_clock(const ConfigNode& root, Scene& scene) {
  scene.frames = root.get<std::int64_t>("frames", scene.frames);
  if (scene.frames < 1 || scene.frames > kMaxFrames)
    root.at("frames").fail(fmt::format("expected 1 to {}, found {}", kMaxFrames, scene.frames));
  scene.rate_hz = root.positive("rate_hz", scene.rate_hz);
  if (scene.rate_hz > kMaxRate_hz)
    root.at("rate_hz").fail(fmt::format("expected at most {} Hz", kMaxRate_hz));
  if (scene.rate_hz < kMinRate_hz)
    root.at("rate_hz").fail(fmt::format("expected at least {} Hz", kMinRate_hz));
  const double duration_s = static_cast<double>(scene.frames - 1) / scene.rate_hz;
  if (duration_s > kMaxDuration_s)
    root.at("rate_hz").fail(
        fmt::format("{} frames last {} s, expected at most {} s", scene.frames, duration_s, kMaxDuration_s));
}

void check_pose(const Pose& pose) {
  if (!pose.translation.allFinite() || !pose.rotation.coeffs().allFinite())
    throw InputError("pose is not finite");
}

// A camera cannot look at a point that its path leads straight over, and numbers may overflow on the way:
// better said now than amid the frames.
void check_motion(const ConfigNode& node, const Motion& motion, const Scene& scene) {
  for (std::int64_t frame = 0; frame < scene.frames; ++frame) try {
      const Pose pose = motion.at(static_cast<double>(scene.stamp_ns(frame)) * 1e-9);
      check_pose(pose);
      if (pose.translation.cwiseAbs().maxCoeff() > kMostCoordinate_m)  // the truth could not be read
        throw InputError(fmt::format("is further than {} m from the origin", kMostCoordinate_m));
    } catch (const InputError& error) {
      node.fail(fmt::format("frame {}: {}", frame, error.what()));
    }
}

double end_s(const Scene& scene) {
  return static_cast<double>(scene.stamp_ns(scene.frames - 1)) * 1e-9;
}

void read_camera_section(const ConfigNode& node, Scene& scene, std::vector<fs::path>& files) {
  if (const auto calibration = node.find("calibration")) {
    scene.camera = read_camera(*calibration);
    calibration->refuse_unknown_keys();
  }
  if (const auto error = node.find("calibration_error")) {
    scene.calibration_error = read_calibration_error(*error);
    error->refuse_unknown_keys();
  }
  scene.given_camera = node.get<bool>("given", scene.given_camera);
  scene.depth = node.get<bool>("depth", scene.depth);
  scene.camera_motion = read_motion(node.at("motion"), {Mover::camera, files, {}, end_s(scene)});
  check_motion(node.at("motion"), scene.camera_motion, scene);
  node.refuse_unknown_keys();
}

std::size_t bytes_of(const std::vector<Mesh>& meshes) {
  std::size_t bytes = 0;
  for (const Mesh& mesh : meshes)
    bytes += mesh.positions.size() * sizeof mesh.positions[0] + mesh.normals.size() * sizeof mesh.normals[0] +
             mesh.uvs.size() * sizeof mesh.uvs[0] + mesh.triangles.size() * sizeof mesh.triangles[0] +
             mesh.texture.total() * mesh.texture.elemSize();
  return bytes;
}

// Each body alone is bounded; so that a short text cannot ask for thousands of the largest.
void check_memory(const ConfigNode& item, const Scene& scene) {
  std::size_t bytes = 0;
  for (const auto* bodies : {&scene.world, &scene.objects})
    for (const Body& body : *bodies) bytes += bytes_of(body.meshes);
  if (bytes > kMostMeshBytes)
    item.fail(fmt::format("meshes and textures up to here take more than {} MiB", kMostMeshBytes >> 20));
}

void read_world(const ConfigNode& list, MaterialDefaults defaults, Scene& scene,
                std::vector<fs::path>& files) {
  for (const ConfigNode& item : list.items()) {
    defaults.seed = kWorldSeed + scene.world.size();
    scene.world.push_back(read_static_body(item, defaults, files));
    check_memory(item, scene);
    try {
      check_pose(scene.world.back().motion.at(0));
    } catch (const InputError& error) {
      item.fail(error.what());
    }
  }
}

// A mesh in millimetres is a thousand times too large.
void warn_of_units(const ConfigNode& item, const Body& body, const Scene& scene) {
  if (body.shape != "mesh" || item.has("scale")) return;
  const Eigen::Vector3d camera_m = body.motion.at(0).inverse() * scene.camera_motion.at(0).translation;
  if ((camera_m.cwiseAbs().array() < body.semi_axes_m.array()).all())
    warn(fmt::format(
        "{}: the camera begins inside {}, which is {:.3g} m long: is its mesh in millimetres? Then it has "
        "`scale: 0.001`",
        item.at("mesh").place(), body.name, 2 * body.semi_axes_m.maxCoeff()));
}

void read_objects(const ConfigNode& list, const MaterialDefaults& defaults, Scene& scene,
                  std::vector<fs::path>& files) {
  std::set<int> ids;
  std::set<std::string> names;
  for (const ConfigNode& item : list.items()) {
    scene.objects.push_back(read_object(item, defaults, files, end_s(scene)));
    check_memory(item, scene);
    const Body& body = scene.objects.back();
    if (!ids.insert(body.id).second)
      item.at("id").fail(fmt::format("{} is the id of another object", body.id));
    if (!names.insert(body.name).second)
      item.at("name").fail(fmt::format("'{}' is the name of another object", body.name));
    check_motion(item.at("motion"), body.motion, scene);
    warn_of_units(item, body, scene);
  }
}

// A key of a sensor that the file has not, which may be meant for one that it has.
void warn_of_made_sensors(const ConfigNode& file, const std::vector<ConfigOverride>& overrides,
                          const Scene& scene) {
  for (const std::string sensor : {"imu", "lidar"}) {
    const auto made = std::ranges::find_if(overrides, [&](const ConfigOverride& value) {
      return value.key == sensor || value.key.starts_with(sensor + '.');
    });
    if (file.has(sensor) || made == overrides.end() || made->key == sensor) continue;
    if (sensor == "lidar" && !scene.lidar->has("pattern") && !scene.lidar->has("csv"))
      continue;  // its reader refuses that
    warn(fmt::format("{}: {} (set, not the file's): makes the sensor, for the scene has no {}",
                     file.file().string(), made->key, sensor));
  }
}

// The text, then the files in the order they are named: the same scene elsewhere has the same hash.
std::string scene_hash(const std::string& text, const std::vector<ConfigOverride>& overrides,
                       const std::vector<fs::path>& files) {
  Hash hash;
  hash.add("scene").add(text);
  for (const ConfigOverride& value : overrides) hash.add("set").add(value.key).add(value.value);
  for (const fs::path& file : files) hash.add_file(file);
  return hash.hex();
}

}  // namespace

std::int64_t Scene::stamp_ns(std::int64_t frame) const {
  return std::llround(static_cast<double>(frame) * 1e9 / rate_hz);
}

std::uint64_t Scene::stream_seed(std::uint64_t seed) const {
  if (noise_seed == 0) return seed;
  RandomStream random(seed, "scene", noise_seed);
  const std::uint64_t high = random.bits();
  return high << 32 | random.bits();
}

Camera Scene::told_camera() const {
  Camera told = camera;
  told.fx *= 1 + calibration_error.focal;
  told.fy *= 1 + calibration_error.focal;
  told.cx += calibration_error.center_px.x();
  told.cy += calibration_error.center_px.y();
  return told;
}

Scene load_scene(const fs::path& path, const std::vector<ConfigOverride>& overrides, Textures textures) {
  return parse_scene(read_file(path, kYamlFile), path, overrides, textures);
}

Scene parse_scene(const std::string& text, const fs::path& path, const std::vector<ConfigOverride>& overrides,
                  Textures textures) {
  const ConfigNode given = ConfigNode::parse(text, path, overrides);
  std::vector<ConfigOverride> all = realism_of(given);
  all.insert(all.begin(), overrides.begin(), overrides.end());
  const ConfigNode root = ConfigNode::parse(text, path, all);
  Scene scene;
  std::vector<fs::path> files;
  scene.name = root.name("name", path.stem().string());
  if (root.has("realism")) scene.realism = read_realism(root);  // realism_of() has followed it
  read_clock(root, scene);
  read_camera_section(root.at("camera"), scene, files);
  read_sensor_models(root, scene);
  if (const auto map = root.find("map")) {
    scene.map_resolution_m = map->positive("resolution_m", scene.map_resolution_m);
    map->refuse_unknown_keys();
  }
  if (scene.lidar)
    if (const auto csv = scene.lidar->find("csv")) files.push_back(resolve_path(*csv));
  MaterialDefaults defaults;
  defaults.amount = read_texture_amount(root, defaults.amount);
  defaults.is_painted = textures == Textures::painted;
  if (const auto world = root.find("world")) read_world(*world, defaults, scene, files);
  if (const auto objects = root.find("objects")) read_objects(*objects, defaults, scene, files);
  if (scene.world.empty() && scene.objects.empty())
    root.fail("has neither world nor objects: nothing to see");
  scene.noise_seed = root.get<std::uint64_t>("noise_seed", 0);
  const double noise_scale = root.get<double>("noise_scale", 1);
  if (!(noise_scale >= 0 && noise_scale <= kMostNoiseScale))
    root.at("noise_scale").fail(fmt::format("expected 0 to {}, found {}", kMostNoiseScale, noise_scale));
  root.refuse_unknown_keys();
  warn_of_idle_keys(given, scene);
  warn_of_made_sensors(ConfigNode::parse(text, path), overrides, scene);
  scene.hash = scene_hash(text, overrides, files);
  scale_noise(scene, noise_scale);
  return scene;
}

}  // namespace uniquadric
