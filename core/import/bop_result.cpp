#include "core/import/bop_result.h"

#include <fmt/format.h>

#include <limits>
#include <map>
#include <optional>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/base/warning.h"
#include "core/import/bop_models.h"
#include "core/import/fields.h"
#include "core/import/result.h"
#include "core/import/result_world.h"
#include "core/sequence/estimated_objects.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::size_t kColumns = 7;  // scene_id,im_id,obj_id,score,R,t,time

// An object's shape about the centre of its box.
struct Model {
  ObjectShape shape;
  Pose model_from_object;
};

Model model_of(const BopModel& box) {
  Model model;
  model.shape.semi_axes_m = box.semi_axes_m;
  model.shape.exponents = {1, 1, 1};
  model.model_from_object.translation = box.center_m;
  return model;
}

struct Detection {
  BoxInCamera box;
  double score = 0;
};

fs::path result_file(const fs::path& source) {
  if (!fs::is_directory(source)) return source;
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(source))
    if (entry.path().extension() == ".csv") files.push_back(entry.path());
  if (files.size() == 1) return files.front();
  throw InputError(source, fmt::format("has {} files .csv, expected one: name the file", files.size()));
}

std::map<int, Model> read_models(const fs::path& folder) {
  std::map<int, Model> models;
  for (const fs::path& file : {folder / "models_info.json", folder / "models/models_info.json"}) {
    if (!fs::exists(file)) continue;
    for (const auto& [id, box] : read_bop_models(file)) models[id] = model_of(box);
    return models;
  }
  for (const auto& [id, shape] : read_object_shapes(folder / "objects.yaml")) models[id] = {shape, {}};
  if (models.empty())
    throw InputError(folder, "has no sizes: neither models_info.json nor objects.yaml is beside the result");
  return models;
}

Pose read_pose_mm(const fs::path& file, int line, const std::vector<double>& rotation,
                  const std::vector<double>& translation_mm) {
  if (rotation.size() != 9)
    throw InputError(file, line, fmt::format("R: expected 9 numbers, found {}", rotation.size()));
  if (translation_mm.size() != 3)
    throw InputError(file, line, fmt::format("t: expected 3 numbers, found {}", translation_mm.size()));
  Pose pose = read_pose_rows(file, line, rotation);
  pose.translation = Eigen::Vector3d(translation_mm.data()) / kBopMmPerM;
  return pose;
}

// The poses that scene_camera.json has of the sequence's frames; none where it has none.
Trajectory read_scene_camera(const fs::path& file, const std::vector<std::int64_t>& stamps_ns) {
  std::map<std::int64_t, Pose> by_frame;
  if (!fs::exists(file)) return {};
  for (const auto& [key, node] : ConfigNode::load(file).entries()) {
    if (!node.has("cam_R_w2c") || !node.has("cam_t_w2c")) continue;
    const auto frame = read_count(file, node.line(), key, "image", std::ssize(stamps_ns));
    by_frame[frame] = read_pose_mm(file, node.line(), node.get<std::vector<double>>("cam_R_w2c"),
                                   node.get<std::vector<double>>("cam_t_w2c"))
                          .inverse();
  }
  Trajectory camera;
  for (const auto& [frame, pose] : by_frame)
    camera.push_back({stamps_ns[static_cast<std::size_t>(frame)], pose});
  return camera;
}

Detection read_detection(const fs::path& file, int line, const Fields& fields, std::int64_t frames,
                         const std::map<int, Model>& models) {
  Detection detection;
  detection.box.frame = read_count(file, line, fields[1], "im_id", frames);
  const int id =
      static_cast<int>(read_count(file, line, fields[2], "obj_id", std::numeric_limits<int>::max()));
  const auto model = models.find(id);
  if (id == 0 || model == models.end())
    throw InputError(file, line, fmt::format("obj_id {} has no size beside the result", id));
  detection.score = read_numbers(file, line, {fields[3]}).front();
  const Pose camera_from_model = read_pose_mm(file, line, read_numbers(file, line, split(fields[4])),
                                              read_numbers(file, line, split(fields[5])));
  detection.box.id = id;
  detection.box.camera_from_object = camera_from_model * model->second.model_from_object;
  detection.box.shape = model->second.shape;
  return detection;
}

// The best instance of each object in each image.
std::vector<BoxInCamera> read_boxes(const fs::path& file, std::int64_t frames,
                                    const std::map<int, Model>& models) {
  std::map<std::pair<std::int64_t, int>, Detection> best;
  std::optional<std::string> scene;
  std::size_t others = 0;
  for_each_row(file, kColumns, [&](int line, const Fields& fields) {
    if (!scene) scene = fields[0];
    if (fields[0] != *scene)
      throw InputError(file, line,
                       fmt::format("scene_id {} after {}: expected one scene", fields[0], *scene));
    const Detection detection = read_detection(file, line, fields, frames, models);
    const auto [place, is_new] = best.try_emplace({detection.box.frame, detection.box.id}, detection);
    if (is_new) return;
    ++others;
    if (detection.score > place->second.score) place->second = detection;
  });
  if (others > 0)
    warn(fmt::format("{}: {} rows are left out: of an object in an image the best score is taken",
                     file.string(), others));
  std::vector<BoxInCamera> boxes;
  for (const auto& [key, detection] : best) boxes.push_back(detection.box);
  return boxes;
}

}  // namespace

Tracks read_bop_result(const fs::path& source, const Sequence& sequence) {
  const fs::path file = result_file(source);
  const fs::path folder = fs::absolute(file).lexically_normal().parent_path();
  const std::vector<std::int64_t> stamps_ns = observed_ns(sequence);
  std::vector<BoxInCamera> boxes = read_boxes(file, std::ssize(stamps_ns), read_models(folder));
  Trajectory camera = read_scene_camera(folder / "scene_camera.json", stamps_ns);
  if (camera.empty()) camera = camera_of_result(folder / "camera.tum", sequence, file.string());
  return placed_in_world(std::move(boxes), camera, sequence, file.string());
}

}  // namespace uniquadric
