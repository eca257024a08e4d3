#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/sequence/stamps.h"
#include "evaluation/report/page.h"
#include "evaluation/report/poses.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using nlohmann::json;

constexpr std::int64_t kMaxDifferenceNs = 10'000'000;  // as evaluate pairs them
// Half a millimetre and less than a tenth of a degree: finer than a pixel of a scene a metre across.
constexpr double kLengthsPerM = 1e3, kParts = 1e3;

double rounded(double value, double parts) {
  const double whole = std::round(value * parts);
  return whole == 0 ? 0 : whole / parts;  // no -0
}

// [x, y, z, qx, qy, qz, qw]
json pose_json(const Pose& pose) {
  json list = json::array();
  for (int i = 0; i < 3; ++i) list.push_back(rounded(pose.translation[i], kLengthsPerM));
  for (int i = 0; i < 4; ++i) list.push_back(rounded(pose.rotation.coeffs()[i], kParts));
  return list;
}

// The entry nearest in time; null where none is near enough.
template <typename Entry>
const Entry* at_time(const std::vector<Entry>& entries, std::int64_t stamp_ns) {
  auto next = std::lower_bound(entries.begin(), entries.end(), stamp_ns,
                               [](const Entry& e, std::int64_t t) { return e.stamp_ns < t; });
  if (next != entries.begin() &&
      (next == entries.end() || stamp_ns - std::prev(next)->stamp_ns <= next->stamp_ns - stamp_ns))
    --next;
  const bool near = next != entries.end() && std::abs(next->stamp_ns - stamp_ns) <= kMaxDifferenceNs;
  return near ? &*next : nullptr;
}

json camera_json(const Trajectory& camera, const std::vector<std::int64_t>& stamps_ns) {
  json list = json::array();
  for (const std::int64_t stamp_ns : stamps_ns) {
    const StampedPose* pose = at_time(camera, stamp_ns);
    list.push_back(pose ? pose_json(pose->pose) : json(nullptr));
  }
  return list;
}

// A value a time, or one alone where all are the same.
json constant_or_all(json values) {
  const bool constant =
      std::all_of(values.begin(), values.end(), [&](const json& v) { return v == values.front(); });
  if (constant && !values.empty()) values.erase(values.begin() + 1, values.end());
  return values;
}

json axes_json(const ObjectState& state) {
  json axes = json::array();
  for (const double axis_m : state.ellipsoid.semi_axes_m) axes.push_back(rounded(axis_m, kLengthsPerM));
  return axes;
}

// [outline, upper, lower, profile axis]
json solid_json(const ObjectState& state) {
  const SuperExponents& q = state.exponents;
  return {rounded(q.outline, 100), rounded(q.upper, 100), rounded(q.lower, 100), state.profile_axis};
}

// Null where not estimated.
json sigma_json(const ObjectState& state) {
  json sigmas = json::array();
  for (int i = 3; i < 6; ++i) {
    const double variance = state.covariance_diagonal[i];
    if (!(variance >= 0)) return nullptr;
    sigmas.push_back(rounded(std::sqrt(variance), 1e4));
  }
  return sigmas;
}

json track_json(const ObjectTrack& track, const std::string& name,
                const std::vector<std::int64_t>& stamps_ns) {
  json poses = json::array(), axes = json::array(), solids = json::array(), sigmas = json::array();
  for (const std::int64_t stamp_ns : stamps_ns) {
    const ObjectState* state = at_time(track.states, stamp_ns);
    poses.push_back(state ? pose_json(state->ellipsoid.world_from_object) : json(nullptr));
    axes.push_back(state ? axes_json(*state) : json(nullptr));
    solids.push_back(state ? solid_json(*state) : json(nullptr));
    sigmas.push_back(state ? sigma_json(*state) : json(nullptr));
  }
  return {{"object", name},
          {"id", track.id},
          {"poses", poses},
          {"semi_axes_m", constant_or_all(std::move(axes))},
          {"solids", constant_or_all(std::move(solids))},
          {"sigmas_m", constant_or_all(std::move(sigmas))}};
}

std::string name_of(const Cell& cell, int id) {
  for (const ObjectSeries& series : cell.evaluation->series)
    if (series.id == id) return series.subject;
  return fmt::format("object_{}", id);
}

// The true camera's stamps, thinned.
std::vector<std::int64_t> shown_stamps(const Tracks& truth, std::size_t count) {
  const auto all = stamps_of(truth.camera);
  std::vector<std::int64_t> kept;
  for (const std::size_t i : evenly_spaced(all.size(), std::min(count, all.size()))) kept.push_back(all[i]);
  return kept;
}

json tracks_json(const Tracks& tracks, const Cell& cell, const std::vector<std::int64_t>& stamps_ns) {
  json objects = json::array();
  for (const ObjectTrack& track : tracks.objects)
    objects.push_back(track_json(track, name_of(cell, track.id), stamps_ns));
  return {{"camera", camera_json(tracks.camera, stamps_ns)}, {"objects", objects}};
}

json unmatched_json(const Tracks& tracks, const std::vector<std::int64_t>& stamps_ns) {
  json list = json::array();
  for (const ObjectTrack& track : tracks.objects)
    list.push_back(track_json(track, fmt::format("track {}", track.id), stamps_ns));
  return list;
}

constexpr std::size_t kFewMotionFrames = 20;  // ours: below, a path has corners

// How many runs are shown, and how many times of each.
struct MotionShare {
  std::size_t runs, frames;
};
MotionShare share_of(const Results& results, const PageOptions& options) {
  std::set<std::pair<std::string, std::string>> runs;
  std::size_t tracks = 0;
  for (const Cell& cell : results.cells)
    if (cell.evaluation && runs.emplace(cell.scene, cell.variant).second)
      tracks += cell.evaluation->subjects.size();  // objects, the camera, and one for what is not matched
  const std::size_t fitting = options.motion_poses / std::max<std::size_t>(1, tracks);
  if (fitting >= kFewMotionFrames) return {runs.size(), std::min(fitting, options.motion_frames)};
  return {runs.size() * options.motion_poses / (tracks * kFewMotionFrames),
          std::min(kFewMotionFrames, options.motion_frames)};
}

}  // namespace

std::string page_motion(const Results& results, const PageOptions& options) {
  const MotionShare share = share_of(results, options);
  json truths = json::array(), runs = json::array();
  std::set<std::pair<std::string, std::string>> seen, without;  // scene, variant
  for (const Cell& cell : results.cells) {
    const fs::path file = evaluation_folder(results, cell) / "poses.csv";
    if (!cell.evaluation) continue;
    if (!fs::exists(file)) {
      without.emplace(cell.scene, cell.variant);
      continue;
    }
    if (!seen.emplace(cell.scene, cell.variant).second || runs.size() == share.runs) continue;
    const ComparedPoses poses = read_poses(file);
    const auto stamps_ns = shown_stamps(poses.truth, share.frames);
    json truth = tracks_json(poses.truth, cell, stamps_ns),
         run = tracks_json(poses.estimate, cell, stamps_ns);
    truth["stamps_ns"] = stamps_ns;
    const auto known = std::find(truths.begin(), truths.end(), truth);  // one for all variants and most seeds
    run["truth"] = known - truths.begin();
    if (known == truths.end()) truths.push_back(std::move(truth));
    run["scene"] = cell.scene, run["variant"] = cell.variant, run["seed"] = cell.seed;
    run["unmatched"] = unmatched_json(poses.unmatched, stamps_ns);
    runs.push_back(std::move(run));
  }
  json absent = json::array();
  for (const auto& run : without)
    if (!seen.contains(run)) absent.push_back({{"scene", run.first}, {"variant", run.second}});
  return json{{"truths", truths}, {"runs", runs}, {"absent", absent}}.dump();
}

}  // namespace uniquadric
