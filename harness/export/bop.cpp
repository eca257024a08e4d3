// The layout of the BOP challenge (Hodan et al., ECCV 2018; bop_toolkit/docs/bop_datasets_format.md):
// millimetres, rotations row by row, poses camera_from_model.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/import/rectify.h"
#include "harness/export/bop_frame.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/run_length.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kMmPerM = 1000;

// The tight box is all the truth knows of a shape, so the diameter is the box's diagonal but for a ball.
Json model_info(const ObjectDescription& object) {
  const Eigen::Vector3d a_mm = kMmPerM * object.semi_axes_m;
  const double diameter_mm = 2 * (object.shape == "ball" ? a_mm.maxCoeff() : a_mm.norm());
  return {{"diameter", diameter_mm}, {"min_x", -a_mm.x()},     {"min_y", -a_mm.y()},    {"min_z", -a_mm.z()},
          {"size_x", 2 * a_mm.x()},  {"size_y", 2 * a_mm.y()}, {"size_z", 2 * a_mm.z()}};
}

Json camera_json(const ExportSource& source, const SequenceFrame& frame) {
  Json json = {{"cam_K", bop_matrix(source.sequence.camera.matrix())},
               {"depth_scale", kMmPerM / source.sequence.depth_units_per_m}};
  if (const auto pose = camera_pose(source, frame)) {
    const Pose camera_from_world = pose->inverse();
    json["cam_R_w2c"] = bop_matrix(camera_from_world.rotation.toRotationMatrix());
    json["cam_t_w2c"] = bop_vector_mm(camera_from_world.translation);
  }
  return json;
}

void write_depth(const Sequence& sequence, const SequenceFrame& frame, const fs::path& path) {
  read_depth(sequence, frame);  // throws for images that cannot be used
  write_png(path, rectify(sequence.camera, read_image(sequence.folder / frame.depth), false));
}

void write_masks(const BopFrame& seen, std::int64_t frame, const fs::path& scene) {
  for (std::size_t i = 0; i < seen.objects.size(); ++i) {
    const ObjectAtFrame& object = seen.objects[i];
    const cv::Mat mask = seen.ids == object.object->id;
    const std::string file = fmt::format("{:06}_{:06}.png", frame, i);
    write_png(scene / "mask_visib" / file, mask);
    if (object.visibility.visible_px == object.visibility.silhouette_px)
      write_png(scene / "mask" / file, mask);
  }
}

Json coco_categories(const ExportTruth& truth) {
  Json list = Json::array();
  for (const ObjectDescription& object : truth.objects)
    list.push_back({{"id", object.id}, {"name", object.name}, {"supercategory", "uniquadric"}});
  return list;
}

void add_coco(const BopFrame& seen, const SequenceFrame& frame, const Camera& camera, Json& coco) {
  coco["images"].push_back({{"id", frame.frame},
                            {"file_name", fmt::format("rgb/{:06}.png", frame.frame)},
                            {"width", camera.width},
                            {"height", camera.height}});
  for (const ObjectAtFrame& object : seen.objects) {
    const int id = object.object->id;
    const auto box = box_of_id(seen.ids, id);
    if (!box) continue;
    coco["annotations"].push_back(
        {{"id", coco["annotations"].size() + 1},
         {"image_id", frame.frame},
         {"category_id", id},
         {"iscrowd", 0},
         {"area", cv::countNonZero(seen.ids == id)},
         {"bbox", bop_box(box)},
         {"segmentation", {{"counts", run_lengths(seen.ids, id)}, {"size", {camera.height, camera.width}}}},
         {"width", camera.width},
         {"height", camera.height},
         {"ignore", false}});
  }
}

void write_models(const ExportTruth& truth, const fs::path& folder) {
  Json models = Json::object();
  for (const ObjectDescription& object : truth.objects)
    models[std::to_string(object.id)] = model_info(object);
  write_text(folder / "models_info.json", models.dump(1) + "\n");
}

// A map by image number, a line an image, as the benchmark writes its files.
std::string by_image(const std::vector<std::string>& images) {
  std::string text = "{\n";
  for (std::size_t i = 0; i < images.size(); ++i)
    text += fmt::format("  \"{}\": {}{}\n", i, images[i], i + 1 < images.size() ? "," : "");
  return text + "}\n";
}

}  // namespace

void write_bop(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  require_images(sequence, "export bop");
  const fs::path scene = folder / "test/000000";
  for (const char* name : {"rgb", "depth", "mask", "mask_visib"}) fs::create_directories(scene / name);
  fs::create_directories(folder / "models");
  std::vector<std::string> cameras, poses, infos;
  Json coco = {{"images", Json::array()}, {"annotations", Json::array()}, {"categories", Json::array()}};
  Progress progress("export bop", std::ssize(sequence.frames), options.quiet);
  for (const SequenceFrame& frame : sequence.frames) {
    const BopFrame seen = bop_frame(source, frame);
    write_color_png(source, frame, true, scene / fmt::format("rgb/{:06}.png", frame.frame));
    if (!frame.depth.empty())
      write_depth(sequence, frame, scene / fmt::format("depth/{:06}.png", frame.frame));
    write_masks(seen, frame.frame, scene);
    cameras.push_back(camera_json(source, frame).dump());
    poses.push_back(bop_poses(seen));
    infos.push_back(bop_infos(seen));
    add_coco(seen, frame, sequence.camera, coco);
    progress.advance();
  }
  write_text(scene / "scene_camera.json", by_image(cameras));
  if (!source.truth) return;
  coco["categories"] = coco_categories(*source.truth);
  write_text(scene / "scene_gt.json", by_image(poses));
  write_text(scene / "scene_gt_info.json", by_image(infos));
  write_text(scene / "scene_gt_coco.json", coco.dump() + "\n");
  write_models(*source.truth, folder / "models");
}

}  // namespace uniquadric
