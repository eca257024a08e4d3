// The layout of the BOP challenge (Hodan et al., ECCV 2018; bop_toolkit/docs/bop_datasets_format.md):
// millimetres, rotations row by row, poses camera_from_model.
#include <fmt/format.h>

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "core/base/files.h"
#include "core/base/progress.h"
#include "harness/export/export.h"
#include "harness/export/export_source.h"
#include "harness/export/run_length.h"
#include "harness/export/writers.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double kMmPerM = 1000;

std::vector<double> row_major(const Eigen::Matrix3d& M) {
  return {M(0, 0), M(0, 1), M(0, 2), M(1, 0), M(1, 1), M(1, 2), M(2, 0), M(2, 1), M(2, 2)};
}

std::vector<double> mm(const Eigen::Vector3d& v_m) {
  return {kMmPerM * v_m.x(), kMmPerM * v_m.y(), kMmPerM * v_m.z()};
}

// The tight box is all the truth knows of a shape, so the diameter is the box's diagonal but for a ball.
Json model_info(const ObjectDescription& object) {
  const Eigen::Vector3d a_mm = kMmPerM * object.semi_axes_m;
  const double diameter_mm = 2 * (object.shape == "ball" ? a_mm.maxCoeff() : a_mm.norm());
  return {{"diameter", diameter_mm}, {"min_x", -a_mm.x()},     {"min_y", -a_mm.y()},    {"min_z", -a_mm.z()},
          {"size_x", 2 * a_mm.x()},  {"size_y", 2 * a_mm.y()}, {"size_z", 2 * a_mm.z()}};
}

std::vector<int> bop_box(const std::optional<PixelBox>& box) {
  if (!box) return {-1, -1, -1, -1};  // the format's own word for none
  return {box->u_min, box->v_min, box->u_max - box->u_min + 1, box->v_max - box->v_min + 1};
}

// Around the whole object: the visible mask's where that is the silhouette, else that of the tight box's
// corners, which goes beyond the image where the object does.
std::optional<PixelBox> silhouette_box(const Camera& camera, const ObjectAtFrame& object,
                                       const std::optional<PixelBox>& visible) {
  const ObjectVisibility& seen = object.visibility;
  if (seen.visible_px == seen.silhouette_px && !seen.touches_border) return visible;
  const Eigen::Matrix<double, 3, 8> corners = box_corners(object);
  if (corners.row(2).minCoeff() <= 0) return visible;  // reaches behind the camera: no outline
  Eigen::Array2d low = Eigen::Array2d::Constant(INFINITY), high = -low;
  for (int i = 0; i < 8; ++i) {
    const Eigen::Array2d pixel = (camera.matrix() * corners.col(i)).hnormalized().array();
    low = low.min(pixel);
    high = high.max(pixel);
  }
  const auto rounded = [](double x) { return static_cast<int>(std::lround(x)); };
  return PixelBox{rounded(low.x()), rounded(low.y()), rounded(high.x()), rounded(high.y())};
}

// A frame's objects that the image would show if nothing hid them, and what is seen of them.
class BopFrame {
 public:
  BopFrame(const ExportSource& source, const SequenceFrame& frame) : camera_(source.sequence.camera) {
    if (!source.truth) return;
    ids_ = rectify(camera_, read_instances(source, frame), false);
    if (!frame.depth.empty()) has_depth_ = rectify(camera_, read_depth(source.sequence, frame), false) > 0;
    for (const ObjectAtFrame& object : objects_at(source, frame))
      if (object.visibility.silhouette_px > 0) objects_.push_back(object);
  }

  const std::vector<ObjectAtFrame>& objects() const { return objects_; }
  const cv::Mat& ids() const { return ids_; }

  Json poses() const {
    Json list = Json::array();
    for (const ObjectAtFrame& object : objects_)
      list.push_back({{"cam_R_m2c", row_major(object.camera_from_object.rotation.toRotationMatrix())},
                      {"cam_t_m2c", mm(object.camera_from_object.translation)},
                      {"obj_id", object.object->id}});
    return list;
  }

  Json info() const {
    Json list = Json::array();
    for (const ObjectAtFrame& object : objects_) {
      const cv::Mat mask = ids_ == object.object->id;
      const auto box = box_of_id(ids_, object.object->id);
      list.push_back({{"bbox_obj", bop_box(silhouette_box(camera_, object, box))},
                      {"bbox_visib", bop_box(box)},
                      {"px_count_all", object.visibility.silhouette_px},
                      {"px_count_valid", has_depth_.empty() ? 0 : cv::countNonZero(mask & has_depth_)},
                      {"px_count_visib", cv::countNonZero(mask)},
                      {"visib_fract", object.visibility.visible_fraction}});
    }
    return list;
  }

 private:
  Camera camera_;
  std::vector<ObjectAtFrame> objects_;
  cv::Mat ids_, has_depth_;
};

Json camera_json(const ExportSource& source, const SequenceFrame& frame) {
  Json json = {{"cam_K", row_major(source.sequence.camera.matrix())},
               {"depth_scale", kMmPerM / source.sequence.depth_units_per_m}};
  if (const auto pose = camera_pose(source, frame)) {
    const Pose camera_from_world = pose->inverse();
    json["cam_R_w2c"] = row_major(camera_from_world.rotation.toRotationMatrix());
    json["cam_t_w2c"] = mm(camera_from_world.translation);
  }
  return json;
}

void write_depth(const Sequence& sequence, const SequenceFrame& frame, const fs::path& path) {
  read_depth(sequence, frame);  // throws for images that cannot be used
  write_png(path, rectify(sequence.camera, read_image(sequence.folder / frame.depth), false));
}

void write_masks(const BopFrame& seen, std::int64_t frame, const fs::path& scene) {
  for (std::size_t i = 0; i < seen.objects().size(); ++i) {
    const ObjectAtFrame& object = seen.objects()[i];
    const cv::Mat mask = seen.ids() == object.object->id;
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
  for (const ObjectAtFrame& object : seen.objects()) {
    const int id = object.object->id;
    const auto box = box_of_id(seen.ids(), id);
    if (!box) continue;
    coco["annotations"].push_back(
        {{"id", coco["annotations"].size() + 1},
         {"image_id", frame.frame},
         {"category_id", id},
         {"iscrowd", 0},
         {"area", cv::countNonZero(seen.ids() == id)},
         {"bbox", bop_box(box)},
         {"segmentation", {{"counts", run_lengths(seen.ids(), id)}, {"size", {camera.height, camera.width}}}},
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

// The same for every frame: the keys are image numbers, a line each, as the benchmark writes them.
std::string by_image(const std::vector<Json>& images) {
  std::string text = "{\n";
  for (std::size_t i = 0; i < images.size(); ++i)
    text += fmt::format("  \"{}\": {}{}\n", i, images[i].dump(), i + 1 < images.size() ? "," : "");
  return text + "}\n";
}

}  // namespace

void write_bop(const ExportSource& source, const ExportOptions& options, const fs::path& folder) {
  const Sequence& sequence = source.sequence;
  const fs::path scene = folder / "test/000000";
  for (const char* name : {"rgb", "depth", "mask", "mask_visib"}) fs::create_directories(scene / name);
  fs::create_directories(folder / "models");
  std::vector<Json> cameras, poses, infos;
  Json coco = {{"images", Json::array()}, {"annotations", Json::array()}, {"categories", Json::array()}};
  Progress progress("export bop", std::ssize(sequence.frames), options.quiet);
  for (const SequenceFrame& frame : sequence.frames) {
    const BopFrame seen(source, frame);
    write_color_png(source, frame, true, scene / fmt::format("rgb/{:06}.png", frame.frame));
    if (!frame.depth.empty())
      write_depth(sequence, frame, scene / fmt::format("depth/{:06}.png", frame.frame));
    write_masks(seen, frame.frame, scene);
    cameras.push_back(camera_json(source, frame));
    poses.push_back(seen.poses());
    infos.push_back(seen.info());
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
