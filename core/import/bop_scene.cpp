#include "core/import/bop_scene.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <string>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/import/bop_models.h"
#include "core/import/fields.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::json;

constexpr double kSameIntrinsics_px = 1e-3;   // ours: more than numbers written as text lose
constexpr std::int64_t kMostImage = 999'999;  // six digits name an image

// JSON and not YAML, whose nodes are bounded to fewer than long scenes have.
Json read_map(const fs::path& file) {
  try {
    Json map = Json::parse(read_text(file));
    if (map.is_object() && !map.empty()) return map;
  } catch (const Json::exception& e) {
    throw InputError(file, std::string("is no JSON: ") + e.what());
  }
  throw InputError(file, "expected a map by image number");
}

// The entry of an image, and what names it in messages.
struct Entry {
  const fs::path& file;
  std::string image;
  const Json& map;

  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(file, fmt::format("image {}: {}", image, what));
  }
  std::vector<double> numbers(const char* key, std::size_t count) const {
    if (!map.is_object() || !map.contains(key)) fail(fmt::format("has no {}", key));
    const Json& list = map.at(key);
    std::vector<double> values;
    if (list.is_array())
      for (const Json& value : list)
        if (value.is_number()) values.push_back(value.get<double>());
    if (!list.is_array() || values.size() != count || list.size() != count)
      fail(fmt::format("{}: expected {} numbers", key, count));
    return values;
  }
  Pose pose(const char* rotation, const char* translation) const {
    const auto R = numbers(rotation, 9), t_mm = numbers(translation, 3);
    Eigen::Matrix<double, 3, 4> matrix;
    matrix << Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(R.data()),
        Eigen::Map<const Eigen::Vector3d>(t_mm.data()) / kBopMmPerM;
    const auto pose = rigid_pose(matrix);
    if (!pose) fail(fmt::format("{} is no rotation", rotation));
    return *pose;
  }
};

std::int64_t image_number(const fs::path& file, const std::string& key) {
  const auto number = parse_integer(key);
  if (!number || *number < 0 || *number > kMostImage)
    throw InputError(file, fmt::format("'{}' is no image number from 0 to {}", key, kMostImage));
  return *number;
}

std::array<double, 4> read_intrinsics(const Entry& entry) {
  const auto K = entry.numbers("cam_K", 9);
  if (!(K[0] > 0 && K[4] > 0) || K[1] != 0 || K[3] != 0 || K[6] != 0 || K[7] != 0 || K[8] != 1)
    entry.fail("cam_K: expected fx 0 cx 0 fy cy 0 0 1");
  return {K[0], K[4], K[2], K[5]};
}

double read_depth_units_per_m(const Entry& entry) {
  const auto scale = entry.map.find("depth_scale");
  if (scale == entry.map.end()) return kBopMmPerM;
  if (!scale->is_number() || !(scale->get<double>() > 0))
    entry.fail("depth_scale: expected a number above 0");
  return kBopMmPerM / scale->get<double>();
}

void read_camera(const Entry& entry, bool is_first, BopScene& scene, BopImage& image) {
  const auto intrinsics_px = read_intrinsics(entry);
  const double units_per_m = read_depth_units_per_m(entry);
  if (is_first) {
    scene.intrinsics_px = intrinsics_px;
    scene.depth_units_per_m = units_per_m;
  }
  for (std::size_t i = 0; i < intrinsics_px.size(); ++i)
    if (std::abs(intrinsics_px[i] - scene.intrinsics_px[i]) > kSameIntrinsics_px)
      entry.fail("the intrinsics change: cam_K is another than in images before, a sequence has one camera");
  if (units_per_m != scene.depth_units_per_m) entry.fail("depth_scale changes: a sequence has one");
  if (entry.map.contains("cam_R_w2c") && entry.map.contains("cam_t_w2c"))
    image.camera_from_world = entry.pose("cam_R_w2c", "cam_t_w2c");
}

void read_objects(const fs::path& file, const std::string& key, const Json& list, BopImage& image) {
  if (!list.is_array()) Entry{file, key, list}.fail("expected a list of objects");
  std::map<int, int> instances;
  for (const Json& item : list) {
    const Entry entry{file, key, item};
    BopInstance object;
    object.camera_from_model = entry.pose("cam_R_m2c", "cam_t_m2c");
    const auto id = item.find("obj_id");
    if (id == item.end() || !id->is_number_integer() || id->get<std::int64_t>() < 1 ||
        id->get<std::int64_t>() > kMostImage)
      entry.fail(fmt::format("obj_id: expected a whole number from 1 to {}", kMostImage));
    object.obj_id = id->get<int>();
    object.instance = instances[object.obj_id]++;
    image.objects.push_back(object);
  }
}

}  // namespace

BopScene read_bop_scene(const fs::path& folder) {
  const fs::path cameras = folder / "scene_camera.json", objects = folder / "scene_gt.json";
  if (!fs::exists(cameras)) throw InputError(folder, "holds no scene: there is no scene_camera.json");
  BopScene scene;
  const Json camera_map = read_map(cameras);
  for (const auto& [key, map] : camera_map.items()) {
    const bool is_first = scene.images.empty();
    read_camera({cameras, key, map}, is_first, scene, scene.images[image_number(cameras, key)]);
  }
  scene.has_objects = fs::exists(objects);
  if (!scene.has_objects) return scene;
  const Json object_map = read_map(objects);
  for (const auto& [key, list] : object_map.items()) {
    const auto image = scene.images.find(image_number(objects, key));
    if (image == scene.images.end())
      throw InputError(objects, fmt::format("image {} does not stand in scene_camera.json", key));
    read_objects(objects, key, list, image->second);
  }
  return scene;
}

}  // namespace uniquadric
