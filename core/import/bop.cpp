#include "core/import/bop.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <set>
#include <utility>

#include "core/base/error.h"
#include "core/import/bop_models.h"
#include "core/import/bop_scene.h"
#include "core/import/images.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

fs::path image_file(const fs::path& scene, std::int64_t number) {
  for (const char* kind : {"rgb", "gray"})
    for (const char* ending : {"png", "jpg"})
      if (fs::path file = scene / fmt::format("{}/{:06}.{}", kind, number, ending); fs::exists(file))
        return file;
  throw InputError(scene / fmt::format("rgb/{:06}.png", number), "is missing, also as .jpg and in gray/");
}

// Ids of objects: the model's, and of further instances of a model those plus multiples of `step`.
struct ObjectIds {
  int step = 1000;
  bool several = false;

  int of(const BopInstance& object) const { return object.obj_id + step * object.instance; }
};

ObjectIds object_ids(const fs::path& file, const BopScene& scene) {
  ObjectIds ids;
  for (const auto& [number, image] : scene.images)
    for (const BopInstance& object : image.objects) {
      while (object.obj_id >= ids.step) ids.step *= 10;
      ids.several |= object.instance > 0;
    }
  for (const auto& [number, image] : scene.images)
    for (const BopInstance& object : image.objects)
      if (ids.of(object) > std::numeric_limits<std::uint16_t>::max())
        throw InputError(file, fmt::format("image {}: instance {} of obj_id {} has no id of 16 bits", number,
                                           object.instance, object.obj_id));
  return ids;
}

cv::Mat read_visible_masks(const std::vector<fs::path>& files, const std::vector<int>& ids,
                           const Camera& camera) {
  cv::Mat masks = cv::Mat::zeros(camera.height, camera.width, CV_16UC1);
  for (std::size_t i = 0; i < files.size(); ++i) {
    const cv::Mat mask = read_image(files[i]);
    if (mask.type() != CV_8UC1 || mask.size() != masks.size())
      throw InputError(files[i],
                       fmt::format("expected an 8-bit grey image of {}x{}", masks.cols, masks.rows));
    masks.setTo(ids[i], mask > 0);
  }
  return masks;
}

void add_masks(const fs::path& scene, std::int64_t number, const BopImage& image, const ObjectIds& ids,
               SequenceFrame& frame, Recording& recording) {
  std::vector<fs::path> files;
  std::vector<int> ids_of_files;
  for (std::size_t i = 0; i < image.objects.size(); ++i) {
    files.push_back(scene / fmt::format("mask_visib/{:06}_{:06}.png", number, i));
    if (!fs::exists(files.back())) throw InputError(files.back(), "is missing");
    ids_of_files.push_back(ids.of(image.objects[i]));
  }
  frame.masks = fmt::format("masks/{:06}.png", number);
  frame.masks_arrival_ns = frame.stamp_ns;
  recording.images.push_back({scene / "mask_visib", frame.masks, ImageKind::masks,
                              [files, ids_of_files, camera = recording.sequence.camera](const fs::path&) {
                                return read_visible_masks(files, ids_of_files, camera);
                              }});
}

void add_frames(const fs::path& folder, const BopScene& scene, const ObjectIds& ids, double rate_hz,
                Recording& recording) {
  const bool has_masks = scene.has_objects && fs::is_directory(folder / "mask_visib");
  for (const auto& [number, image] : scene.images) {
    const fs::path source = image_file(folder, number);
    const bool is_grey = source.parent_path().filename() == "gray";
    SequenceFrame& frame =
        add_frame(recording.sequence, std::llround(1e9 * static_cast<double>(number) / rate_hz),
                  fmt::format("rgb/{:06}{}", number, is_grey ? ".png" : source.extension().string()));
    recording.images.push_back({source, frame.rgb, ImageKind::color, make_color});
    const fs::path depth = fmt::format("depth/{:06}.png", number);
    if (fs::exists(folder / depth)) {
      frame.depth = depth;
      recording.images.push_back({folder / depth, depth, ImageKind::depth});
    }
    if (has_masks) add_masks(folder, number, image, ids, frame, recording);
  }
}

Camera read_camera(const fs::path& folder, const BopScene& scene) {
  const cv::Mat first = read_image(image_file(folder, scene.images.begin()->first));
  Camera camera;
  camera.width = first.cols, camera.height = first.rows;
  camera.fx = scene.intrinsics_px[0], camera.fy = scene.intrinsics_px[1];
  camera.cx = scene.intrinsics_px[2], camera.cy = scene.intrinsics_px[3];
  return camera;
}

fs::path models_folder(const fs::path& scene, const fs::path& wanted) {
  if (!wanted.empty()) {
    if (!fs::exists(wanted / "models_info.json")) throw InputError(wanted, "has no models_info.json");
    return wanted;
  }
  const fs::path dataset = fs::weakly_canonical(scene) / "../..";
  for (const char* name : {"models", "models_eval"})
    if (fs::exists(dataset / name / "models_info.json")) return (dataset / name).lexically_normal();
  return {};
}

// A model's mesh in its object's frame.
SurfaceFile read_mesh(const fs::path& file, const Eigen::Vector3d& center_m) {
  SurfaceFile mesh = read_surface_ply(file);
  if (mesh.triangles.empty()) throw InputError(file, "has no faces");
  for (Eigen::Vector3f& point : mesh.points)
    point = (point.cast<double>() / kBopMmPerM - center_m).cast<float>();
  return mesh;
}

ObjectDescription describe(const BopInstance& object, const ObjectIds& ids, const BopModel& model) {
  ObjectDescription description;
  description.id = ids.of(object);
  description.name = fmt::format("object_{}", object.obj_id);
  if (object.instance > 0) description.name += fmt::format("_{}", object.instance + 1);
  description.semi_axes_m = model.semi_axes_m;
  description.shape = "mesh";
  return description;
}

// The truth's objects that have a model, and which models are missing.
class ObjectsTruth {
 public:
  ObjectsTruth(fs::path models, const ObjectIds& ids, RecordedTruth& truth)
      : folder_(std::move(models)), ids_(ids), truth_(truth) {
    if (!folder_.empty()) models_ = read_bop_models(folder_ / "models_info.json");
  }

  void add(std::int64_t stamp_ns, const Pose& world_from_camera, const BopInstance& object) {
    const auto model = models_.find(object.obj_id);
    if (model == models_.end()) {
      missing_.insert(object.obj_id);
      return;
    }
    Trajectory& trajectory = truth_.objects_at[ids_.of(object)];
    if (trajectory.empty()) describe_object(object, model->second);
    Pose pose = world_from_camera * object.camera_from_model * Pose{{1, 0, 0, 0}, model->second.center_m};
    pose.rotation.normalize();
    trajectory.push_back({stamp_ns, pose});
  }
  const std::set<int>& missing() const { return missing_; }

 private:
  void describe_object(const BopInstance& object, const BopModel& model) {
    ObjectDescription description = describe(object, ids_, model);
    const fs::path mesh = folder_ / fmt::format("obj_{:06}.ply", object.obj_id);
    if (fs::exists(mesh)) {
      description.mesh = mesh.filename().string();
      truth_.meshes[description.id] = [mesh, center_m = model.center_m] { return read_mesh(mesh, center_m); };
    }
    truth_.objects.push_back(description);
  }

  fs::path folder_;
  const ObjectIds& ids_;
  RecordedTruth& truth_;
  std::map<int, BopModel> models_{};
  std::set<int> missing_{};
};

void add_truth(const fs::path& folder, const BopScene& scene, const ObjectIds& ids, const fs::path& models,
               Recording& recording) {
  const auto frames_with_pose =
      std::count_if(scene.images.begin(), scene.images.end(),
                    [](const auto& image) { return image.second.camera_from_world.has_value(); });
  const bool in_sensor_frame = frames_with_pose == 0;
  if (in_sensor_frame && !scene.has_objects) return;
  RecordedTruth& truth = recording.truth.emplace();
  truth.notes.in_sensor_frame = in_sensor_frame;
  ObjectsTruth objects(models, ids, truth);
  auto frame = recording.sequence.frames.begin();
  for (const auto& [number, image] : scene.images) {
    const std::int64_t stamp_ns = (frame++)->stamp_ns;
    if (!in_sensor_frame && !image.camera_from_world) continue;
    const Pose world_from_camera = in_sensor_frame ? Pose{} : image.camera_from_world->inverse();
    truth.camera.push_back({stamp_ns, world_from_camera});
    for (const BopInstance& object : image.objects) objects.add(stamp_ns, world_from_camera, object);
  }
  std::ranges::sort(truth.objects, {}, &ObjectDescription::id);
  if (!in_sensor_frame) recording.sequence.given_camera = truth.camera;
  const std::string cameras = (folder / "scene_camera.json").string();
  if (in_sensor_frame)
    recording.left_out.push_back(cameras +
                                 ": no pose places the camera in the world: objects are kept in its frame");
  else if (frames_with_pose < std::ssize(scene.images))
    recording.left_out.push_back(fmt::format("{}: {} of {} images have no pose", cameras,
                                             std::ssize(scene.images) - frames_with_pose,
                                             scene.images.size()));
  if (!objects.missing().empty())
    recording.left_out.push_back(fmt::format(
        "the poses of obj_id {} are left out, for {}: --models", fmt::join(objects.missing(), ", "),
        models.empty() ? "there is no models_info.json" : "models_info.json has no sizes of them"));
}

Recording read_recording(const fs::path& folder, const ImportBopOptions& options) {
  const BopScene scene = read_bop_scene(folder);
  const ObjectIds ids = object_ids(folder / "scene_gt.json", scene);
  Recording recording;
  recording.sequence = begin_sequence(recording_name(folder));
  recording.sequence.camera = read_camera(folder, scene);
  recording.sequence.depth_units_per_m = scene.depth_units_per_m;
  recording.sequence.rate_hz = options.rate_hz;
  add_frames(folder, scene, ids, options.rate_hz, recording);
  add_truth(folder, scene, ids, models_folder(folder, options.models), recording);
  if (ids.several)
    recording.left_out.push_back(
        fmt::format("{}: objects of one model are told apart by their order in an image's list alone",
                    (folder / "scene_gt.json").string()));
  return recording;
}

}  // namespace

void import_bop(const fs::path& scene, const ImportBopOptions& options, const fs::path& out) {
  if (!fs::is_directory(scene)) throw InputError(scene, "is not a folder");
  write_recording(read_recording(scene, options), options, out);
}

}  // namespace uniquadric
