#include "simulator/families/scene_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simulator/scene/body_reader.h"
#include "simulator/scene/motion_reader.h"

namespace uniquadric {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::int64_t kFrameStep = 3;  // of the checks: a tenth of a second
constexpr double kFarthest_m = 60;      // that counts as looked at

// Oriented boxes of these half extents, by the separating axis theorem (Gottschalk et al., SIGGRAPH 1996).
bool boxes_meet(const Pose& a_from_b, const Vector3d& a, const Vector3d& b) {
  constexpr double kParallel = 1e-9;
  const Matrix3d R = a_from_b.rotation.toRotationMatrix();
  const Matrix3d abs = R.cwiseAbs().array() + kParallel;
  const Vector3d& t = a_from_b.translation;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(t[i]) > a[i] + abs.row(i).dot(b)) return false;
    if (std::abs(t.dot(R.col(i))) > abs.col(i).dot(a) + b[i]) return false;
  }
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      const int i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
      const double reach = a[i1] * abs(i2, j) + a[i2] * abs(i1, j) + b[j1] * abs(i, j2) + b[j2] * abs(i, j1);
      if (std::abs(t[i2] * R(i1, j) - t[i1] * R(i2, j)) > reach) return false;
    }
  return true;
}

}  // namespace

SceneDraft::SceneDraft(const FamilyOptions& options, const std::string& camera, double clear_m)
    : options_(options), clear_m_(clear_m), camera_(camera) {
  const ConfigNode node = ConfigNode::parse("camera:\n" + camera, "family");
  std::vector<std::filesystem::path> files;  // remains empty: nothing recorded is drawn
  sensors_.camera_motion = read_motion(node.at("camera").at("motion"), {Mover::camera, files});
}

void SceneDraft::keep_clear_of(const std::string& motion, const Vector3d& size_m) {
  Body body;
  std::vector<std::filesystem::path> files;
  body.motion = read_motion(ConfigNode::parse(motion, "family"), {Mover::body, files});
  body.semi_axes_m = size_m / 2;
  bodies_.push_back(body);
}

std::string SceneDraft::object_text(const Thing& thing, const std::string& motion) const {
  return fmt::format("  - id: {}\n    name: {}_{}\n{}    motion:\n{}", next_id_, thing.name, next_id_,
                     thing.keys, motion);
}

bool SceneDraft::meets_another(const Body& body) const {
  const Vector3d half = body.semi_axes_m.array() + clear_m_;
  for (std::int64_t frame = 0; frame < options_.frames; frame += kFrameStep) {
    const Pose body_from_world = body.motion.at(time_s(frame)).inverse();
    for (const Body& other : bodies_) {
      const Pose body_from_other = body_from_world * other.motion.at(time_s(frame));
      const double apart_m = body_from_other.translation.norm();
      if (apart_m < half.norm() + other.semi_axes_m.norm() &&
          boxes_meet(body_from_other, half, other.semi_axes_m))
        return true;
    }
  }
  return false;
}

bool SceneDraft::is_looked_at(const Body& body) const {
  for (std::int64_t frame = 0; frame < options_.frames; frame += kFrameStep) {
    const Pose camera_from_body =
        sensors_.camera_motion.at(time_s(frame)).inverse() * body.motion.at(time_s(frame));
    const auto pixel = sensors_.camera.project(camera_from_body.translation);
    if (pixel && sensors_.camera.contains(*pixel) && camera_from_body.translation.z() < kFarthest_m)
      return true;
  }
  return false;
}

bool SceneDraft::add(const Thing& thing, const std::string& motion) {
  const std::string text = object_text(thing, motion);
  std::vector<std::filesystem::path> files;
  Body body = read_object(ConfigNode::parse("objects:\n" + text, "family").at("objects").items().front(),
                          TextureAmount::none, files);
  if (meets_another(body) || !is_looked_at(body)) return false;
  body.meshes.clear();
  bodies_.push_back(std::move(body));
  objects_ += text;
  ++next_id_;
  ++count_;
  return true;
}

std::optional<std::string> SceneDraft::add_drawn(const Thing& thing,
                                                 const std::function<std::string()>& draw_motion) {
  constexpr int kMostTries = 40;
  for (int i = 0; i < kMostTries; ++i)
    if (const std::string motion = draw_motion(); add(thing, motion)) return motion;
  return std::nullopt;
}

void SceneDraft::add_unscored(const Thing& thing, const std::string& motion) {
  Thing unscored = thing;
  unscored.keys += "    scored: false\n";
  objects_ += object_text(unscored, motion);
  ++next_id_;
}

std::string SceneDraft::text() const {
  return "camera:\n" + camera_ + (world_.empty() ? "" : "world:\n" + world_) +
         (objects_.empty() ? "" : "objects:\n" + objects_);
}

}  // namespace uniquadric
