#include <nlohmann/json.hpp>
#include <numbers>

#include "evaluation/pose_json_parts.h"

namespace uniquadric {
using nlohmann::json;

json to_json(const std::optional<Statistics>& s) {
  if (!s) return nullptr;
  return {{"rmse", s->rmse}, {"mean", s->mean}, {"median", s->median}, {"std", s->std},
          {"min", s->min},   {"max", s->max},   {"sse", s->sse},       {"n", s->n}};
}

json to_json(AlignmentKind kind, const Alignment& alignment, const char* transform) {
  const auto& [scale, pose] = alignment;
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return {{"kind", to_string(kind)},
          {transform,
           {{"position_m", {t.x(), t.y(), t.z()}},
            {"quaternion_xyzw", {q.x(), q.y(), q.z(), q.w()}},
            {"scale", scale}}}};
}

json to_json(const std::optional<Drift>& drift) {
  if (!drift) return nullptr;
  const auto& percent = drift->max_translation_percent_of_path;
  return {{"alignment", "first"},
          {"max_translation_m", drift->max_translation_m},
          {"max_translation_percent_of_path", percent ? json(*percent) : json()},
          {"max_angle_deg", drift->max_angle_rad * 180 / std::numbers::pi},
          {"max_angle_rad", drift->max_angle_rad}};
}

}  // namespace uniquadric
