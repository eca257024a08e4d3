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
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kTracksSchema = 1;
// No body is smaller or larger than that, and the volumes of such are numbers.
constexpr double kLeastSemiAxis_m = 1e-9, kMostSemiAxis_m = 1e6;
constexpr double kLeastExponent = 1, kMostExponent = 2;  // of superellipsoid_support: beyond is no body
constexpr double kMostAxisRatio = 1e6;  // as `metric` has it: IoU of thinner ones drowns in rounding
const char* const kStateHeader =
    "frame,timestamp_ns,id,semi_axis_x_m,semi_axis_y_m,semi_axis_z_m,exponent_q,var_semi_axis_x_m2,var_semi_"
    "axis_y_m2,"
    "var_semi_axis_z_m2,var_translation_x_m2,var_translation_y_m2,var_translation_z_m2,var_rotation_x_rad2,"
    "var_rotation_y_rad2,var_rotation_z_rad2,state,motion,exponent_upper_q,exponent_lower_q,profile_axis";
constexpr std::size_t kColumns[] = {17, 18, 21};  // what came later older estimates lack
constexpr std::string_view kAxisNames = "xyz";

std::optional<ObjectStatus> parse_status(std::string_view text) {
  for (const auto status :
       {ObjectStatus::tentative, ObjectStatus::active, ObjectStatus::occluded, ObjectStatus::lost})
    if (text == to_string(status)) return status;
  return std::nullopt;
}

std::optional<ObjectMotion> parse_motion(std::string_view text) {
  for (const auto motion : {ObjectMotion::unknown, ObjectMotion::at_rest, ObjectMotion::moving})
    if (text == to_string(motion)) return motion;
  return std::nullopt;
}

fs::path trajectory_file(const fs::path& folder, int id) {
  return folder / "objects" / fmt::format("{}.tum", id);
}

// What is wrong with these semi-axes; empty: nothing.
std::string fault_of(const Eigen::Vector3d& semi_axes_m) {
  if (!(semi_axes_m.minCoeff() > 0)) return "expected numbers greater than 0";
  if (semi_axes_m.minCoeff() < kLeastSemiAxis_m)
    return fmt::format("expected at least {} m", kLeastSemiAxis_m);
  if (semi_axes_m.maxCoeff() > kMostSemiAxis_m) return fmt::format("expected at most {} m", kMostSemiAxis_m);
  if (semi_axes_m.maxCoeff() > kMostAxisRatio * semi_axes_m.minCoeff())
    return fmt::format("are more than {} times apart", kMostAxisRatio);
  return {};
}

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

// One line of objects.csv, its pose still missing.
ObjectState parse_state(const fs::path& path, int line, const std::vector<std::string_view>& fields,
                        int& id) {
  const auto fail = [&](std::size_t column) {
    throw InputError(path, line,
                     fmt::format("column {}: '{}' is not a valid value", split(kStateHeader, ',')[column],
                                 fields[column]));
  };
  const auto integer = [&](std::size_t column) {
    const auto value = parse_integer(fields[column]);
    if (!value) fail(column);
    return *value;
  };
  const auto positive = [&](std::size_t column) {
    const auto value = parse_double(fields[column]);
    if (!value || *value <= 0) fail(column);
    return *value;
  };
  ObjectState state;
  state.frame = integer(0);
  const auto stamp_ns = parse_stamp_of_ns(fields[1]);
  if (!stamp_ns) fail(1);
  state.stamp_ns = *stamp_ns;
  const auto number = integer(2);
  if (number <= 0 || number > std::numeric_limits<int>::max()) fail(2);
  id = static_cast<int>(number);
  for (int i = 0; i < 3; ++i) state.ellipsoid.semi_axes_m[i] = positive(3 + i);
  if (const std::string fault = fault_of(state.ellipsoid.semi_axes_m); !fault.empty())
    throw InputError(path, line, "semi-axes: " + fault);
  const auto exponent = [&](std::size_t column) {
    const double value = positive(column);
    if (value < kLeastExponent || value > kMostExponent)
      throw InputError(
          path, line,
          fmt::format("column {}: '{}' is not from {} (a box) to {} (an ellipsoid)",
                      split(kStateHeader, ',')[column], fields[column], kLeastExponent, kMostExponent));
    return value;
  };
  state.exponents.outline = state.exponents.upper = state.exponents.lower = exponent(6);
  for (int i = 0; i < 9; ++i) {
    if (fields[7 + i].empty()) continue;
    const auto value = parse_double(fields[7 + i]);
    if (!value || *value < 0) fail(7 + i);
    state.covariance_diagonal[i] = *value;
  }
  const auto status = parse_status(fields[16]);
  if (!status) fail(16);
  state.status = *status;
  if (fields.size() == kColumns[0]) return state;
  const auto motion = parse_motion(fields[17]);
  if (!motion) fail(17);
  state.motion = *motion;
  if (fields.size() == kColumns[1]) return state;
  state.exponents.upper = exponent(18);
  state.exponents.lower = exponent(19);
  const auto axis = kAxisNames.find(fields[20]);
  if (fields[20].size() != 1 || axis == std::string_view::npos) fail(20);
  state.profile_axis = static_cast<int>(axis);
  return state;
}

// A trajectory without a row would be left out unseen; an empty one has none.
void refuse_unlisted(const fs::path& folder, const std::map<int, ObjectTrack>& tracks) {
  if (!fs::is_directory(folder / "objects")) return;
  std::set<fs::path> unlisted;
  for (const auto& entry : fs::directory_iterator(folder / "objects"))
    if (entry.path().extension() == ".tum") unlisted.insert(entry.path());
  for (const auto& [id, track] : tracks) unlisted.erase(trajectory_file(folder, id));
  for (const fs::path& file : unlisted)
    if (!read_tum(file).empty()) throw InputError(file, "objects.csv has no row of this object");
}

// What is wrong with the columns that a header names; empty: nothing.
std::string header_fault(const std::vector<std::string_view>& columns) {
  const auto known = split(kStateHeader, ',');
  std::string unknown;
  std::size_t least = kColumns[0];  // up to the last known one that is there
  for (const std::string_view name : columns) {
    const auto at = static_cast<std::size_t>(std::ranges::find(known, name) - known.begin());
    if (at < known.size()) least = std::max(least, at + 1);
    if (at == known.size() && unknown.empty()) unknown = fmt::format("column '{}' is unknown", name);
  }
  const std::size_t wanted = *std::ranges::lower_bound(kColumns, least);
  for (std::size_t i = 0; i < wanted; ++i)
    if (std::ranges::find(columns, known[i]) == columns.end())
      return fmt::format("{}{}column '{}' is missing", unknown, unknown.empty() ? "" : ", ", known[i]);
  if (!unknown.empty()) return unknown;
  for (std::size_t i = 0; i < columns.size(); ++i)
    if (i >= wanted || columns[i] != known[i])
      return fmt::format("column '{}' stands out of order, or twice", columns[i]);
  return {};
}

std::vector<ObjectTrack> read_estimated_objects(const fs::path& folder) {
  const fs::path file = folder / "objects.csv";
  std::size_t columns = 0;
  std::map<int, ObjectTrack> tracks;
  bool header = true;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (std::exchange(header, false)) {
          columns = fields.size();
          if (const std::string fault = header_fault(fields); !fault.empty())
            throw InputError(file, line, fmt::format("{}; expected the header {}", fault, kStateHeader));
          return;
        }
        if (fields.size() != columns)
          throw InputError(file, line, fmt::format("expected {} columns, found {}", columns, fields.size()));
        int id = 0;
        const ObjectState state = parse_state(file, line, fields, id);
        ObjectTrack& track = tracks[id];
        track.id = id;
        if (!track.states.empty() && state.stamp_ns <= track.states.back().stamp_ns)
          throw InputError(file, line,
                           fmt::format("timestamp {} of object {} does not come after {}", state.stamp_ns, id,
                                       track.states.back().stamp_ns));
        if (!track.states.empty() && state.frame <= track.states.back().frame)
          throw InputError(file, line,
                           fmt::format("frame {} of object {} does not come after {}", state.frame, id,
                                       track.states.back().frame));
        track.states.push_back(state);
      },
      ',');
  if (header) throw InputError(file, "is empty, expected a header");
  std::vector<ObjectTrack> result;
  for (auto& [id, track] : tracks) {
    const fs::path poses_file = trajectory_file(folder, id);
    const Trajectory poses = read_tum(poses_file);
    if (poses.size() != track.states.size())
      throw InputError(poses_file, fmt::format("has {} poses, objects.csv has {} states of object {}",
                                               poses.size(), track.states.size(), id));
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (poses[i].stamp_ns != track.states[i].stamp_ns)
        throw InputError(poses_file, fmt::format("pose {} has stamp {} ns, objects.csv {} ns", i,
                                                 poses[i].stamp_ns, track.states[i].stamp_ns));
      track.states[i].ellipsoid.world_from_object = poses[i].pose;
    }
    result.push_back(std::move(track));
  }
  refuse_unlisted(folder, tracks);
  return result;
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

std::vector<ObjectDescription> read_objects_yaml(const fs::path& path) {
  const ConfigNode root = ConfigNode::load(path);
  if (const int schema = root.get<int>("schema"); schema != kTracksSchema)
    root.at("schema").fail(
        fmt::format("version {} is not supported (this program reads {})", schema, kTracksSchema));
  root.get<std::string>("scene_hash", "");  // for who compares folders
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
    node.refuse_unknown_keys();
    if (object.id <= 0) node.at("id").fail("expected an integer greater than 0");
    if (!ids.insert(object.id).second) node.at("id").fail(fmt::format("{} stands twice", object.id));
    if (const auto fault = fault_of(object.semi_axes_m); !fault.empty()) node.at("semi_axes_m").fail(fault);
    if (object.symmetry && !allows(object.semi_axes_m, *object.symmetry))
      node.at("symmetry").fail("does not go with these semi-axes: equal ones are within 5 %");
    objects.push_back(object);
  }
  root.refuse_unknown_keys();
  std::sort(objects.begin(), objects.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
  return objects;
}

void write_objects_yaml(const fs::path& path, const std::vector<ObjectDescription>& objects,
                        const std::string& scene_hash) {
  std::string text = fmt::format("schema: {}\n", kTracksSchema);
  if (!scene_hash.empty()) text += fmt::format("scene_hash: \"{}\"\n", scene_hash);
  text += fmt::format("objects:{}\n", objects.empty() ? " []" : "");
  for (const auto& object : objects) {
    const auto& a = object.semi_axes_m;
    text += fmt::format("  - {{id: {}, name: {}, semi_axes_m: [{}, {}, {}], shape: {}, mesh: {}", object.id,
                        yaml_quoted(object.name), a.x(), a.y(), a.z(), yaml_quoted(object.shape),
                        yaml_quoted(object.mesh));
    if (object.symmetry) text += fmt::format(", symmetry: {}", to_string(*object.symmetry));
    text += "}\n";
  }
  write_text(path, text);
}

Tracks read_tracks(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  Tracks tracks;
  tracks.camera = read_tum(folder / "camera.tum");
  if (fs::exists(folder / "camera.yaml")) tracks.calibration = read_camera_yaml(folder / "camera.yaml");
  if (fs::exists(folder / "objects.csv"))
    tracks.objects = read_estimated_objects(folder);
  else if (fs::exists(folder / "objects.yaml"))
    tracks.objects = read_truth_objects(folder, tracks.camera);
  else
    throw InputError(folder, "has neither objects.yaml (truth) nor objects.csv (estimate)");
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
