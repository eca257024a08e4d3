#include "core/sequence/tracks.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/text.h"
#include "core/sequence/calibration.h"
#include "core/sequence/estimated_objects.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kTracksSchema = 1;

std::vector<ObjectTrack> read_truth_objects(const fs::path& folder, const Trajectory& camera) {
  std::map<std::int64_t, std::int64_t> frame_of_stamp;
  for (const auto& pose : camera) frame_of_stamp.emplace(pose.stamp_ns, std::ssize(frame_of_stamp));
  std::vector<ObjectTrack> tracks;
  for (const ObjectDescription& object : read_objects_yaml(folder / "objects.yaml")) {
    ObjectTrack track{object.id, object.name, {}};
    const fs::path file = trajectory_file(folder, object.id);
    for (const auto& [stamp_ns, pose] : read_tum(file)) {
      const auto frame = frame_of_stamp.find(stamp_ns);
      if (frame == frame_of_stamp.end())
        throw InputError(file, fmt::format("stamp {} is no frame of camera.tum", format_stamp(stamp_ns)));
      ObjectState state;
      state.frame = frame->second;
      state.stamp_ns = stamp_ns;
      state.ellipsoid = {pose, object.semi_axes_m};
      track.states.push_back(state);
    }
    tracks.push_back(std::move(track));
  }
  return tracks;
}

TruthNotes read_notes(const ConfigNode& root) {
  return {root.choice("labels", {"all", "partial"}, "all") == "partial",
          root.choice("frame", {"world", "sensor"}, "world") == "sensor"};
}

}  // namespace

const char* to_string(ObjectStatus status) {
  switch (status) {
    case ObjectStatus::tentative:
      return "tentative";
    case ObjectStatus::active:
      return "active";
    case ObjectStatus::occluded:
      return "occluded";
    case ObjectStatus::lost:
      return "lost";
  }
  return "";
}

const char* to_string(ObjectMotion motion) {
  switch (motion) {
    case ObjectMotion::unknown:
      return "unknown";
    case ObjectMotion::at_rest:
      return "static";
    case ObjectMotion::moving:
      return "dynamic";
  }
  return "";
}

TruthNotes read_truth_notes(const fs::path& path) {
  return read_notes(ConfigNode::load(path));
}

std::vector<ObjectDescription> read_objects_yaml(const fs::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  if (const int schema = root.get<int>("schema"); schema != kTracksSchema)
    root.at("schema").fail(
        fmt::format("version {} is not supported (this program reads {})", schema, kTracksSchema));
  root.get<std::string>("scene_hash", "");  // for who compares folders
  read_notes(root);
  std::vector<ObjectDescription> objects;
  std::set<int> ids;
  for (const ConfigNode& node : root.at("objects").items()) {
    ObjectDescription object;
    object.id = node.get<int>("id");
    object.name = node.name("name");
    object.semi_axes_m = node.get<Eigen::Vector3d>("semi_axes_m");
    object.shape = node.get<std::string>("shape", "");
    object.mesh = node.get<std::string>("mesh", "");
    if (const auto symmetry = node.find("symmetry")) {
      object.symmetry = parse_body_symmetry(symmetry->as<std::string>());
      if (!object.symmetry) symmetry->fail("expected box, revolution, sphere or none");
    }
    object.is_scored = node.get<bool>("scored", true);
    node.refuse_unknown_keys();
    if (object.id <= 0) node.at("id").fail("expected an integer greater than 0");
    if (!ids.insert(object.id).second) node.at("id").fail(fmt::format("{} stands twice", object.id));
    if (const auto fault = semi_axes_fault(object.semi_axes_m); !fault.empty())
      node.at("semi_axes_m").fail(fault);
    if (object.symmetry && !allows(object.semi_axes_m, *object.symmetry))
      node.at("symmetry").fail("does not go with these semi-axes: equal ones are within 5 %");
    objects.push_back(object);
  }
  root.refuse_unknown_keys();
  std::sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return objects;
}

void write_objects_yaml(const fs::path& path, const std::vector<ObjectDescription>& objects,
                        const std::string& scene_hash, const TruthNotes& notes) {
  std::string text = fmt::format("schema: {}\n", kTracksSchema);
  if (notes.is_partial) text += "labels: partial\n";
  if (notes.in_sensor_frame) text += "frame: sensor\n";
  if (!scene_hash.empty()) text += fmt::format("scene_hash: \"{}\"\n", scene_hash);
  text += fmt::format("objects:{}\n", objects.empty() ? " []" : "");
  for (const auto& object : objects) {
    const auto& a = object.semi_axes_m;
    text += fmt::format("  - {{id: {}, name: {}, semi_axes_m: [{}, {}, {}], shape: {}, mesh: {}", object.id,
                        yaml_quoted(object.name), a.x(), a.y(), a.z(), yaml_quoted(object.shape),
                        yaml_quoted(object.mesh));
    if (object.symmetry) text += fmt::format(", symmetry: {}", to_string(*object.symmetry));
    if (!object.is_scored) text += ", scored: false";
    text += "}\n";
  }
  write_text(path, text);
}

void number_frames(Tracks& tracks) {
  std::set<std::int64_t> stamps_ns;
  for (const StampedPose& pose : tracks.camera) stamps_ns.insert(pose.stamp_ns);
  for (const ObjectTrack& track : tracks.objects)
    for (const ObjectState& state : track.states) stamps_ns.insert(state.stamp_ns);
  const std::vector<std::int64_t> sorted(stamps_ns.begin(), stamps_ns.end());
  for (ObjectTrack& track : tracks.objects)
    for (ObjectState& state : track.states)
      if (state.frame < 0) state.frame = std::ranges::lower_bound(sorted, state.stamp_ns) - sorted.begin();
}

Tracks read_tracks(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  const auto has = [&](const char* name) { return fs::exists(folder / name); };
  const bool is_truth = !has("objects.csv") && has("objects.yaml") && !is_size_list(folder / "objects.yaml");
  if (!has("objects.csv") && !has("objects.yaml") && (has("run.yaml") || !has("camera.tum")))
    throw InputError(folder, "has neither objects.yaml (truth, or sizes) nor objects.csv (estimate)");
  Tracks tracks;
  if (is_truth || has("run.yaml") || has("camera.tum")) tracks.camera = read_tum(folder / "camera.tum");
  if (has("camera.yaml")) tracks.calibration = read_camera_yaml(folder / "camera.yaml");
  tracks.objects = is_truth ? read_truth_objects(folder, tracks.camera) : read_estimated_objects(folder);
  number_frames(tracks);
  return tracks;
}

void write_estimate(const fs::path& folder, const Tracks& tracks) {
  write_tum(folder / "camera.tum", tracks.camera);
  fs::create_directories(folder / "objects");
  std::vector<std::pair<int, const ObjectState*>> rows;
  for (const auto& track : tracks.objects) {
    Trajectory poses;
    for (const auto& state : track.states) {
      poses.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
      rows.emplace_back(track.id, &state);
    }
    write_tum(trajectory_file(folder, track.id), poses);
  }
  std::stable_sort(rows.begin(), rows.end(),
                   [](const auto& a, const auto& b) { return a.second->stamp_ns < b.second->stamp_ns; });
  std::string text = std::string(kStateHeader) + "\n";
  for (const auto& [id, state] : rows) {
    const auto& a = state->ellipsoid.semi_axes_m;
    text += fmt::format("{},{},{},{},{},{},{}", state->frame, state->stamp_ns, id, a.x(), a.y(), a.z(),
                        state->exponents.outline);
    for (const double variance : state->covariance_diagonal)
      text += std::isfinite(variance) && variance >= 0 ? fmt::format(",{}", variance) : ",";
    text += fmt::format(",{},{},{},{},{}\n", to_string(state->status), to_string(state->motion),
                        state->exponents.upper, state->exponents.lower, kAxisNames[state->profile_axis]);
  }
  write_text(folder / "objects.csv", text);
}

}  // namespace uniquadric
