#include <fmt/format.h>

#include "evaluation/evaluation_files.h"

namespace uniquadric {
namespace {

constexpr const char* kHeader =
    "frame,timestamp_ns,object_id,name,matched_id,ape_translation_m,ape_rotation_rad,ape_rotation_naive_rad,"
    "iou3d,iou3d_solid,surface_f1,chamfer_m,"
    "iou3d_monte_carlo,iou3d_stderr,iou2d,iou2d_ellipse,d_shape_m,est_semi_axis_x_m,est_semi_axis_y_m,"
    "est_semi_axis_z_m,true_semi_axis_x_m,true_semi_axis_y_m,true_semi_axis_z_m,rpe_translation_m,rpe_"
    "rotation_rad,"
    "motion_error_translation_m,motion_error_rotation_rad,visible_fraction,visible,occluded,arc_deg,"
    "sigma_translation_m,sigma_rotation_rad,sigma_semi_axes_m\n";

std::string cell(const std::optional<double>& value) {
  return value ? fmt::format(",{}", *value) : ",";
}

std::string cells(const std::optional<PoseError>& error) {
  return error ? fmt::format(",{},{}", error->translation_m, error->rotation_rad) : ",,";
}

std::string row(const ObjectEvaluation& object, const ObjectFrame& frame) {
  std::string text = fmt::format("{},{},{},{},", frame.frame, frame.stamp_ns, object.id, object.name);
  if (frame.estimate && object.matched_id) text += fmt::format("{}", *object.matched_id);
  text += cells(frame.ape) + cell(frame.ape_rotation_naive_rad) + cell(frame.iou3d) +
          cell(frame.iou3d_solid) + cell(frame.surface_f1) + cell(frame.chamfer_m);
  const auto& sampled = frame.iou3d_monte_carlo;
  text += sampled ? fmt::format(",{},{}", sampled->iou, sampled->standard_error) : ",,";
  text += cell(frame.iou2d) + cell(frame.iou2d_ellipse) + cell(frame.d_shape_m);
  for (int i = 0; i < 3; ++i)
    text += frame.estimate ? fmt::format(",{}", frame.estimate->semi_axes_m[i]) : ",";
  for (int i = 0; i < 3; ++i) text += fmt::format(",{}", frame.true_semi_axes_m[i]);
  return text + cells(frame.rpe) + cells(frame.motion) + cell(frame.visible_fraction) +
         (frame.visible ? ",1" : ",0") + (frame.occluded ? ",1" : ",0") + cell(frame.arc_deg) +
         cell(frame.stated.translation_m) + cell(frame.stated.rotation_rad) + cell(frame.stated.semi_axes_m) +
         "\n";
}

}  // namespace

std::string frames_csv(const std::vector<ObjectEvaluation>& objects) {
  std::string text = kHeader;
  for (const ObjectEvaluation& object : objects)
    for (const ObjectFrame& frame : object.frames) text += row(object, frame);
  return text;
}

}  // namespace uniquadric
