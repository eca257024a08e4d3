#include "evaluation/report/poses.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/base/text.h"
#include "evaluation/evaluation_files.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// One line of the file, being read.
struct Line {
  const fs::path& file;
  int number;
  const std::vector<std::string_view>& fields;

  [[noreturn]] void fail(std::size_t column, const char* expected) const {
    throw InputError(file, number,
                     fmt::format("column {}: '{}' is {}", kPosesColumns[column], fields[column], expected));
  }
  std::int64_t integer(std::size_t column) const {
    const auto value = parse_integer(fields[column]);
    if (!value) fail(column, "no integer");
    return *value;
  }
  double real(std::size_t column) const {
    const auto value = parse_double(fields[column]);
    if (!value) fail(column, "not a finite number");
    return *value;
  }
  Pose pose() const {
    Pose pose;
    pose.translation = {real(4), real(5), real(6)};
    pose.rotation = Eigen::Quaterniond(real(10), real(7), real(8), real(9));
    if (!(std::abs(pose.rotation.norm() - 1) < 1e-3)) fail(7, "of a quaternion that is not of unit length");
    return pose;
  }
};

std::size_t check_header(const fs::path& file, int number, const std::vector<std::string_view>& fields) {
  const bool is_known = fields.size() == kPosesColumns.size() || fields.size() == kFewPosesColumns;
  if (!is_known || !std::equal(fields.begin(), fields.end(), kPosesColumns.begin()))
    throw InputError(file, number, "expected the header source,subject,id,timestamp_ns,...");
  return fields.size();
}

ObjectTrack& track_of(Tracks& tracks, int id) {
  for (ObjectTrack& track : tracks.objects)
    if (track.id == id) return track;
  return tracks.objects.emplace_back(ObjectTrack{id, {}, {}});
}

// Stamps must increase within a trajectory: what is shown is looked up by them.
void check_order(const Line& line, std::optional<std::int64_t> last, std::int64_t stamp_ns) {
  if (last && stamp_ns <= *last) line.fail(3, "not after the one before");
}

void add_camera(const Line& line, Trajectory& camera) {
  const std::int64_t stamp_ns = line.integer(3);
  check_order(line, camera.empty() ? std::nullopt : std::optional(camera.back().stamp_ns), stamp_ns);
  camera.push_back({stamp_ns, line.pose()});
}

void add_solid(const Line& line, ObjectState& state) {
  state.exponents = {line.real(14), line.real(15), line.real(16)};
  for (std::size_t i = 14; i < 17; ++i)
    if (!(line.real(i) >= 1)) line.fail(i, "below 1");
  const std::int64_t axis = line.integer(17);
  if (axis < 0 || axis > 2) line.fail(17, "none of 0, 1, 2");
  state.profile_axis = static_cast<int>(axis);
  for (std::size_t i = 0; i < 3; ++i)
    if (!line.fields[18 + i].empty()) {
      const double sigma_m = line.real(18 + i);
      state.covariance_diagonal[static_cast<Eigen::Index>(3 + i)] = sigma_m * sigma_m;
    }
}

void add_state(const Line& line, Tracks& tracks) {
  ObjectTrack& track = track_of(tracks, static_cast<int>(line.integer(2)));
  ObjectState state;
  state.stamp_ns = line.integer(3);
  check_order(line, track.states.empty() ? std::nullopt : std::optional(track.states.back().stamp_ns),
              state.stamp_ns);
  state.ellipsoid = {line.pose(), {line.real(11), line.real(12), line.real(13)}};
  if (!(state.ellipsoid.semi_axes_m.minCoeff() > 0)) line.fail(11, "of semi-axes that are not positive");
  if (line.fields.size() > kFewPosesColumns) add_solid(line, state);
  track.states.push_back(state);
}

void add_row(const Line& line, std::size_t columns, ComparedPoses& poses) {
  if (line.fields.size() != columns)
    throw InputError(line.file, line.number,
                     fmt::format("expected {} columns, found {}", columns, line.fields.size()));
  const std::string_view source = line.fields[0], subject = line.fields[1];
  if (source != "truth" && source != "estimate") line.fail(0, "neither truth nor estimate");
  Tracks& tracks = source == "truth" ? poses.truth : poses.estimate;
  if (subject == "camera")
    add_camera(line, tracks.camera);
  else if (subject == "object")
    add_state(line, tracks);
  else if (subject == "unmatched" && source == "estimate")
    add_state(line, poses.unmatched);
  else
    line.fail(1, "no subject of this source");
}

}  // namespace

ComparedPoses read_poses(const fs::path& file) {
  ComparedPoses poses;
  std::size_t columns = 0;
  for_each_line(
      file,
      [&](int number, const std::vector<std::string_view>& fields) {
        if (columns > 0) return add_row({file, number, fields}, columns, poses);
        columns = check_header(file, number, fields);
      },
      ',');
  if (columns == 0) throw InputError(file, "is empty, expected a header");
  return poses;
}

}  // namespace uniquadric
