#include "harness/export/bop_frame.h"
#include "core/import/rectify.h"

#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

namespace uniquadric {
namespace {
using Json = nlohmann::ordered_json;

constexpr double kMmPerM = 1000;

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

}  // namespace

std::vector<double> bop_matrix(const Eigen::Matrix3d& M) {
  return {M(0, 0), M(0, 1), M(0, 2), M(1, 0), M(1, 1), M(1, 2), M(2, 0), M(2, 1), M(2, 2)};
}

std::vector<double> bop_vector_mm(const Eigen::Vector3d& v_m) {
  return {kMmPerM * v_m.x(), kMmPerM * v_m.y(), kMmPerM * v_m.z()};
}

std::vector<int> bop_box(const std::optional<PixelBox>& box) {
  if (!box) return {-1, -1, -1, -1};
  return {box->u_min, box->v_min, box->u_max - box->u_min + 1, box->v_max - box->v_min + 1};
}

BopFrame bop_frame(const ExportSource& source, const SequenceFrame& frame) {
  BopFrame seen{source.sequence.camera, {}, {}, {}};
  if (!source.truth) return seen;
  seen.ids = rectify(seen.camera, read_instances(source, frame), false);
  if (!frame.depth.empty())
    seen.has_depth = rectify(seen.camera, read_depth(source.sequence, frame), false) > 0;
  for (const ObjectAtFrame& object : objects_at(source, frame))
    if (object.visibility.silhouette_px > 0) seen.objects.push_back(object);
  return seen;
}

std::string bop_poses(const BopFrame& frame) {
  Json list = Json::array();
  for (const ObjectAtFrame& object : frame.objects)
    list.push_back({{"cam_R_m2c", bop_matrix(object.camera_from_object.rotation.toRotationMatrix())},
                    {"cam_t_m2c", bop_vector_mm(object.camera_from_object.translation)},
                    {"obj_id", object.object->id}});
  return list.dump();
}

std::string bop_infos(const BopFrame& frame) {
  Json list = Json::array();
  for (const ObjectAtFrame& object : frame.objects) {
    const cv::Mat mask = frame.ids == object.object->id;
    const auto box = box_of_id(frame.ids, object.object->id);
    const int valid_px = frame.has_depth.empty() ? 0 : cv::countNonZero(mask & frame.has_depth);
    list.push_back({{"bbox_obj", bop_box(silhouette_box(frame.camera, object, box))},
                    {"bbox_visib", bop_box(box)},
                    {"px_count_all", object.visibility.silhouette_px},
                    {"px_count_valid", valid_px},
                    {"px_count_visib", cv::countNonZero(mask)},
                    {"visib_fract", object.visibility.visible_fraction}});
  }
  return list.dump();
}

}  // namespace uniquadric
