#include "core/sequence/estimated_objects.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <optional>
#include <utility>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/text.h"
#include "core/sequence/stamps.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// No body is smaller or larger than that, and the volumes of such are numbers.
constexpr double kLeastSemiAxis_m = 1e-9, kMostSemiAxis_m = 1e6;
constexpr double kLeastExponent = 1, kMostExponent = 2;  // of superellipsoid_support: beyond is no body
constexpr double kMostAxisRatio = 1e6;  // as `metric` has it: IoU of thinner ones drowns in rounding
// Seconds with six decimals, as many programs write them, are the stamp in nanoseconds still.
constexpr std::int64_t kSameStamp_ns = 1000;

enum Column : std::size_t {
  kFrame,
  kStamp,
  kId,
  kSemiAxes,
  kExponent = kSemiAxes + 3,
  kVariances,
  kStatus = kVariances + 9,
  kMotion,
  kUpper,
  kLower,
  kProfileAxis,
  kColumns
};

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

bool is_exponent(double value) {
  return value >= kLeastExponent && value <= kMostExponent;
}

int parse_id(const ConfigNode& node, const std::string& text) {
  const auto id = parse_integer(text);
  if (!id || *id <= 0 || *id > std::numeric_limits<int>::max())
    node.fail(fmt::format("'{}' is no id of an object: expected an integer greater than 0", text));
  return static_cast<int>(*id);
}

void read_exponents(const ConfigNode& node, ObjectShape& shape) {
  const ConfigNode body = node.at("superellipsoid");
  const auto q = body.get<std::vector<double>>("q");
  if (q.size() != 3 || !std::ranges::all_of(q, is_exponent))
    body.at("q").fail("expected [outline, upper, lower], each from 1 (a box) to 2 (an ellipsoid)");
  shape.exponents = {q[0], q[1], q[2]};
  shape.profile_axis = static_cast<int>(kAxisNames.find(body.choice("axis", {"x", "y", "z"}, "z")));
  body.refuse_unknown_keys();
  node.refuse_unknown_keys();
}

ObjectShape read_shape(const ConfigNode& node) {
  const bool has_size = node.has("size_m");
  if (has_size == node.has("semi_axes_m")) node.fail("expected either size_m or semi_axes_m");
  ObjectShape shape{has_size ? Eigen::Vector3d(node.get<Eigen::Vector3d>("size_m") / 2)
                             : node.get<Eigen::Vector3d>("semi_axes_m"),
                    {},
                    2};
  if (const std::string fault = semi_axes_fault(shape.semi_axes_m); !fault.empty())
    node.at(has_size ? "size_m" : "semi_axes_m").fail(fault);
  const auto described = node.find("shape");
  if (described && described->is_map())
    read_exponents(*described, shape);
  else if (node.choice("shape", {"box", "ellipsoid"}, has_size ? "box" : "ellipsoid") == "box")
    shape.exponents = kBoxExponents;
  node.get<std::string>("name", "");
  node.refuse_unknown_keys();
  return shape;
}

// The reader of one row of objects.csv, whose header says where the columns are.
class Row {
 public:
  Row(const fs::path& file, int line, const std::vector<std::string_view>& fields,
      const std::array<std::optional<std::size_t>, kColumns>& place)
      : file_(file), line_(line), fields_(fields), place_(place) {}

  // A column that is there and not empty.
  std::optional<std::string_view> text(std::size_t column) const {
    if (!place_[column] || fields_[*place_[column]].empty()) return std::nullopt;
    return fields_[*place_[column]];
  }
  [[noreturn]] void fail(std::size_t column, const std::string& what = "is not a valid value") const {
    throw InputError(
        file_, line_,
        fmt::format("column {}: '{}' {}", split(kStateHeader, ',')[column], text(column).value_or(""), what));
  }
  std::optional<double> number(std::size_t column, double least) const {
    if (!text(column)) return std::nullopt;
    const auto value = parse_double(*text(column));
    if (!value || *value < least) fail(column);
    return value;
  }
  // `parse` gives nothing for a text that is none.
  template <typename Parse>
  auto value(std::size_t column, const Parse& parse) const -> decltype(parse(std::string_view())) {
    if (!text(column)) return std::nullopt;
    const auto result = parse(*text(column));
    if (!result) fail(column);
    return result;
  }
  std::optional<double> exponent(std::size_t column) const {
    const auto value = number(column, 0);
    if (value && !is_exponent(*value))
      fail(column, fmt::format("is not from {} (a box) to {} (an ellipsoid)", kLeastExponent, kMostExponent));
    return value;
  }
  std::optional<Eigen::Vector3d> semi_axes() const {
    Eigen::Vector3d axes;
    if (!text(kSemiAxes) && !text(kSemiAxes + 1) && !text(kSemiAxes + 2)) return std::nullopt;
    for (int i = 0; i < 3; ++i) {
      const auto axis = number(kSemiAxes + i, 0);
      if (!axis || *axis <= 0) fail(kSemiAxes + i);
      axes[i] = *axis;
    }
    if (const std::string fault = semi_axes_fault(axes); !fault.empty())
      throw InputError(file_, line_, "semi-axes: " + fault);
    return axes;
  }

 private:
  const fs::path& file_;
  int line_;
  const std::vector<std::string_view>& fields_;
  const std::array<std::optional<std::size_t>, kColumns>& place_;
};

int id_of(const Row& row) {
  const auto id = row.value(kId, parse_integer);
  if (!id || *id <= 0 || *id > std::numeric_limits<int>::max()) row.fail(kId);
  return static_cast<int>(*id);
}

std::optional<int> parse_axis(std::string_view text) {
  const auto axis = kAxisNames.find(text);
  if (text.size() != 1 || axis == std::string_view::npos) return std::nullopt;
  return static_cast<int>(axis);
}

// A row's state, its pose still missing; what it does not say is the shape's, or the default.
ObjectState state_of(const Row& row, const ObjectShape* shape) {
  ObjectState state;
  const auto stamp_ns = row.value(kStamp, parse_stamp_of_ns);
  if (!stamp_ns) row.fail(kStamp);
  state.stamp_ns = *stamp_ns;
  state.frame = row.value(kFrame, parse_integer).value_or(-1);
  const auto semi_axes_m = row.semi_axes();
  if (!semi_axes_m && !shape) row.fail(kSemiAxes, "is missing, and objects.yaml has no size of this object");
  state.ellipsoid.semi_axes_m = semi_axes_m ? *semi_axes_m : shape->semi_axes_m;
  if (shape) {
    state.exponents = shape->exponents;
    state.profile_axis = shape->profile_axis;
  }
  if (const auto q = row.exponent(kExponent)) state.exponents = {*q, *q, *q};
  state.exponents.upper = row.exponent(kUpper).value_or(state.exponents.upper);
  state.exponents.lower = row.exponent(kLower).value_or(state.exponents.lower);
  state.profile_axis = row.value(kProfileAxis, parse_axis).value_or(state.profile_axis);
  for (int i = 0; i < 9; ++i)
    if (const auto variance = row.number(kVariances + i, 0)) state.covariance_diagonal[i] = *variance;
  state.status = row.value(kStatus, parse_status).value_or(state.status);
  state.motion = row.value(kMotion, parse_motion).value_or(state.motion);
  return state;
}

std::array<std::optional<std::size_t>, kColumns> read_header(const fs::path& file, int line,
                                                             const std::vector<std::string_view>& names) {
  const auto known = split(kStateHeader, ',');
  std::array<std::optional<std::size_t>, kColumns> place;
  for (std::size_t i = 0; i < names.size(); ++i) {
    const auto at = static_cast<std::size_t>(std::ranges::find(known, names[i]) - known.begin());
    if (at == known.size())
      throw InputError(file, line,
                       fmt::format("column '{}' is unknown; known are {}", names[i], kStateHeader));
    if (place[at]) throw InputError(file, line, fmt::format("column '{}' stands twice", names[i]));
    place[at] = i;
  }
  for (const Column needed : {kStamp, kId})
    if (!place[needed]) throw InputError(file, line, fmt::format("column '{}' is missing", known[needed]));
  return place;
}

void require_later(const fs::path& file, int line, const ObjectTrack& track, const ObjectState& state) {
  if (track.states.empty()) return;
  const ObjectState& last = track.states.back();
  if (state.stamp_ns <= last.stamp_ns)
    throw InputError(file, line,
                     fmt::format("timestamp {} of object {} does not come after {}", state.stamp_ns, track.id,
                                 last.stamp_ns));
  if (state.frame <= last.frame && last.frame >= 0)
    throw InputError(
        file, line,
        fmt::format("frame {} of object {} does not come after {}", state.frame, track.id, last.frame));
}

// Rows of objects.csv, without poses.
std::map<int, ObjectTrack> read_rows(const fs::path& file, const std::map<int, ObjectShape>& shapes) {
  std::optional<std::array<std::optional<std::size_t>, kColumns>> place;
  std::size_t columns = 0;
  std::map<int, ObjectTrack> tracks;
  for_each_line(
      file,
      [&](int line, const std::vector<std::string_view>& fields) {
        if (!place) {
          place = read_header(file, line, fields);
          columns = fields.size();
          return;
        }
        if (fields.size() != columns)
          throw InputError(file, line, fmt::format("expected {} columns, found {}", columns, fields.size()));
        const Row row(file, line, fields, *place);
        const int id = id_of(row);
        ObjectTrack& track = tracks[id];
        track.id = id;
        const auto shape = shapes.find(id);
        const ObjectState state = state_of(row, shape == shapes.end() ? nullptr : &shape->second);
        require_later(file, line, track, state);
        track.states.push_back(state);
      },
      ',');
  if (!place) throw InputError(file, "is empty, expected a header");
  return tracks;
}

void take_poses(const fs::path& folder, ObjectTrack& track) {
  const fs::path file = trajectory_file(folder, track.id);
  const Trajectory poses = read_tum(file);
  if (poses.size() != track.states.size())
    throw InputError(file, fmt::format("has {} poses, objects.csv has {} states of object {}", poses.size(),
                                       track.states.size(), track.id));
  for (std::size_t i = 0; i < poses.size(); ++i) {
    if (std::abs(poses[i].stamp_ns - track.states[i].stamp_ns) > kSameStamp_ns)
      throw InputError(file, fmt::format("pose {} has stamp {} ns, objects.csv {} ns", i, poses[i].stamp_ns,
                                         track.states[i].stamp_ns));
    track.states[i].ellipsoid.world_from_object = poses[i].pose;
  }
}

// Ids of the files objects/ID.tum.
std::vector<int> trajectory_ids(const fs::path& folder) {
  std::vector<int> ids;
  if (!fs::is_directory(folder / "objects")) return ids;
  for (const auto& entry : fs::directory_iterator(folder / "objects")) {
    if (entry.path().extension() != ".tum") continue;
    ids.push_back(id_of_file(entry.path()));
    if (entry.path().filename() != fmt::format("{}.tum", ids.back()))
      throw InputError(entry.path(), fmt::format("expected the name {}.tum", ids.back()));
  }
  std::ranges::sort(ids);
  return ids;
}

}  // namespace

fs::path trajectory_file(const fs::path& folder, int id) {
  return folder / "objects" / fmt::format("{}.tum", id);
}

std::string semi_axes_fault(const Eigen::Vector3d& semi_axes_m) {
  if (!(semi_axes_m.minCoeff() > 0)) return "expected numbers greater than 0";
  if (semi_axes_m.minCoeff() < kLeastSemiAxis_m)
    return fmt::format("expected at least {} m", kLeastSemiAxis_m);
  if (semi_axes_m.maxCoeff() > kMostSemiAxis_m) return fmt::format("expected at most {} m", kMostSemiAxis_m);
  if (semi_axes_m.maxCoeff() > kMostAxisRatio * semi_axes_m.minCoeff())
    return fmt::format("are more than {} times apart", kMostAxisRatio);
  return {};
}

int id_of_file(const fs::path& file) {
  const auto id = parse_integer(file.stem().string());
  if (!id || *id <= 0 || *id > std::numeric_limits<int>::max())
    throw InputError(file, "is named by no id: expected an integer greater than 0");
  return static_cast<int>(*id);
}

std::map<int, ObjectShape> read_object_shapes(const fs::path& file) {
  std::map<int, ObjectShape> shapes;
  if (!fs::exists(file)) return shapes;
  const ConfigNode root = ConfigNode::load(file);
  for (const auto& [key, node] : root.entries())
    if (!shapes.emplace(parse_id(node, key), read_shape(node)).second) node.fail("stands twice");
  return shapes;
}

ObjectTrack track_of_shape(const fs::path& file, const std::map<int, ObjectShape>& shapes) {
  const int id = id_of_file(file);
  ObjectTrack track{id, "", {}};
  const Trajectory poses = read_tum(file);
  const auto shape = shapes.find(id);
  if (!poses.empty() && shape == shapes.end())
    throw InputError(file, fmt::format("objects.yaml has no size of object {}: expected a line {}: {{size_m: "
                                       "[x, y, z]}}",
                                       id, id));
  for (const auto& [stamp_ns, pose] : poses) {
    ObjectState state;
    state.stamp_ns = stamp_ns;
    state.frame = -1;
    state.ellipsoid = {pose, shape->second.semi_axes_m};
    state.exponents = shape->second.exponents;
    state.profile_axis = shape->second.profile_axis;
    track.states.push_back(state);
  }
  return track;
}

bool is_size_list(const fs::path& objects_yaml) {
  const ConfigNode root = ConfigNode::load(objects_yaml);
  return root.is_map() && !root.has("schema") && !root.has("objects");
}

std::vector<ObjectTrack> read_estimated_objects(const fs::path& folder) {
  const fs::path csv = folder / "objects.csv", sizes = folder / "objects.yaml";
  const bool has_rows = fs::exists(csv);
  const auto shapes = read_object_shapes(sizes);
  std::map<int, ObjectTrack> tracks = has_rows ? read_rows(csv, shapes) : std::map<int, ObjectTrack>{};
  for (auto& [id, track] : tracks) take_poses(folder, track);
  for (const int id : trajectory_ids(folder)) {
    if (tracks.contains(id)) continue;
    ObjectTrack track = has_rows ? ObjectTrack{} : track_of_shape(trajectory_file(folder, id), shapes);
    if (has_rows && !read_tum(trajectory_file(folder, id)).empty())
      throw InputError(trajectory_file(folder, id), "objects.csv has no row of this object");
    if (!track.states.empty()) tracks.emplace(id, std::move(track));
  }
  for (const auto& [id, shape] : shapes)
    if (!has_rows && !tracks.contains(id))
      throw InputError(sizes, fmt::format("object {} has no poses: objects/{}.tum is {}", id, id,
                                          fs::exists(trajectory_file(folder, id)) ? "empty" : "missing"));
  std::vector<ObjectTrack> result;
  for (auto& [id, track] : tracks) result.push_back(std::move(track));
  return result;
}

}  // namespace uniquadric
