#include "simulator/families/scene_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/warning.h"
#include "core/sequence/calibration.h"
#include "simulator/scene/body_reader.h"
#include "simulator/scene/motion_reader.h"

namespace uniquadric {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::int64_t kFrameStep = 3;  // between looks: what is seen so rarely is not tracked
constexpr double kFarthest_m = 60;      // that counts as seen

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

// Whether the way from `a` to `b` leads through a box of these half extents (slabs: Kay and Kajiya, SIGGRAPH
// 1986).
bool box_hides(const Pose& box_from_world, const Vector3d& half_m, const Vector3d& a_m, const Vector3d& b_m) {
  const Vector3d from = box_from_world * a_m, way = box_from_world * b_m - from;
  double enters = 0, leaves = 1;
  for (int k = 0; k < 3; ++k) {
    if (way[k] == 0 && std::abs(from[k]) > half_m[k]) return false;
    if (way[k] == 0) continue;
    const double one = (-half_m[k] - from[k]) / way[k], other = (half_m[k] - from[k]) / way[k];
    enters = std::max(enters, std::min(one, other));
    leaves = std::min(leaves, std::max(one, other));
  }
  return enters < leaves;
}

}  // namespace

SceneDraft::SceneDraft(const FamilyOptions& options, const std::string& camera, double clear_m)
    : options_(options), clear_m_(clear_m), camera_(options.lens + camera) {
  const ConfigNode node = ConfigNode::parse("camera:\n" + camera_, "family");
  std::vector<std::filesystem::path> files;  // remains empty: nothing recorded is drawn
  if (const auto calibration = node.at("camera").find("calibration"))
    sensors_.camera = read_camera(*calibration);
  sensors_.camera_motion = read_motion(node.at("camera").at("motion"), {Mover::camera, files});
}

void SceneDraft::keep_clear_of(const std::string& motion, const Vector3d& size_m, bool hides) {
  Body body;
  std::vector<std::filesystem::path> files;
  body.motion = read_motion(ConfigNode::parse(motion, "family"), {Mover::body, files});
  body.semi_axes_m = size_m / 2;
  boxes_.push_back({body, false, hides});
}

std::string SceneDraft::object_text(const Thing& thing, const std::string& motion) const {
  return fmt::format("  - id: {}\n    name: {}_{}\n{}    motion:\n{}", next_id_, thing.name, next_id_,
                     thing.keys, motion);
}

bool SceneDraft::meets_another(const Body& body) const {
  const Vector3d half = body.semi_axes_m.array() + clear_m_;
  for (std::int64_t frame = 0; frame < options_.frames; ++frame) {
    const Pose body_from_world = body.motion.at(time_s(frame)).inverse();
    for (const auto& [other, is_object, hides] : boxes_) {
      const Pose body_from_other = body_from_world * other.motion.at(time_s(frame));
      const double apart_m = body_from_other.translation.norm();
      if (apart_m < half.norm() + other.semi_axes_m.norm() &&
          boxes_meet(body_from_other, half, other.semi_axes_m))
        return true;
    }
  }
  return false;
}

bool SceneDraft::leaves(const Body& body) const {
  const double reach_m = half_m_ - body.semi_axes_m.norm();
  for (std::int64_t frame = 0; frame < options_.frames; ++frame)
    if (body.motion.at(time_s(frame)).translation.head<2>().cwiseAbs().maxCoeff() > reach_m) return true;
  return false;
}

// Its middle is in the image, and a third of the places inside it have no other box before them.
bool SceneDraft::is_seen_at(std::size_t index, double time_s) const {
  const Body& body = boxes_[index].body;
  const Pose world_from_camera = sensors_.camera_motion.at(time_s), world_from_body = body.motion.at(time_s);
  const Vector3d middle_m = world_from_camera.inverse() * world_from_body.translation;
  const auto pixel = sensors_.camera.project(middle_m);
  if (!pixel || !sensors_.camera.contains(*pixel) || middle_m.z() > kFarthest_m) return false;
  std::vector<std::pair<Pose, Vector3d>> before;  // what may hide it
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    if (i != index && boxes_[i].hides)
      before.emplace_back(boxes_[i].body.motion.at(time_s).inverse(), boxes_[i].body.semi_axes_m);
  constexpr int kPlaces = 27;
  int seen = 0;
  for (int place = 0; place < kPlaces; ++place) {
    const Vector3d share(place % 3 - 1, place / 3 % 3 - 1, place / 9 - 1);
    const Vector3d at_m = world_from_body * (0.7 * share.cwiseProduct(body.semi_axes_m));
    const bool is_hidden = std::ranges::any_of(before, [&](const auto& box) {
      return box_hides(box.first, box.second, world_from_camera.translation, at_m);
    });
    seen += is_hidden ? 0 : 1;
  }
  return 3 * seen >= kPlaces;
}

bool SceneDraft::is_seen(std::size_t index) const {
  for (std::int64_t frame = 0; frame < options_.frames; frame += kFrameStep)
    if (is_seen_at(index, time_s(frame))) return true;
  return false;
}

bool SceneDraft::all_seen() const {
  for (std::size_t i = 0; i < boxes_.size(); ++i)
    if (boxes_[i].is_object && !is_seen(i)) return false;
  return true;
}

// Nothing where no smooth curve leads through the way-points that were drawn.
std::optional<Body> SceneDraft::read(const std::string& object) {
  std::vector<std::filesystem::path> files;
  const ConfigNode node = ConfigNode::parse("objects:\n" + object, "family");
  try {
    Body body = read_object(node.at("objects").items().front(), {.is_painted = false}, files);
    body.meshes.clear();
    return body;
  } catch (const InputError&) {
    return std::nullopt;
  }
}

bool SceneDraft::add(const Thing& thing, const std::string& motion) {
  const std::string text = object_text(thing, motion);
  std::optional<Body> body = read(text);
  if (!body || leaves(*body) || meets_another(*body)) return false;
  boxes_.push_back({std::move(*body), true, true});
  if (!all_seen()) {
    boxes_.pop_back();
    return false;
  }
  objects_ += text;
  ++next_id_;
  ++count_;
  return true;
}

std::optional<std::string> SceneDraft::add_drawn(
    const Thing& thing, const std::function<std::optional<std::string>()>& draw_motion, int most) {
  for (int i = 0; i < most; ++i)
    if (const auto motion = draw_motion(); motion && add(thing, *motion)) return motion;
  return std::nullopt;
}

void SceneDraft::add_unscored(const Thing& thing, const std::string& motion) {
  Thing unscored = thing;
  unscored.keys += "    scored: false\n";
  objects_ += object_text(unscored, motion);
  ++next_id_;
}

std::string SceneDraft::text() const {
  if (count_ == 0)
    throw InputError(
        fmt::format("{}: frames: no object finds a way clear of the rest for {} frames; set fewer",
                    options_.family, options_.frames));
  if (options_.count > count_)
    warn(fmt::format("{} of {} objects find a place in the scene", count_, options_.count));
  return "camera:\n" + camera_ + (world_.empty() ? "" : "world:\n" + world_) +
         (objects_.empty() ? "" : "objects:\n" + objects_);
}

}  // namespace uniquadric
