#include "harness/result/check_result.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <optional>
#include <set>

#include "core/base/error.h"
#include "core/import/result.h"
#include "core/sequence/estimated_objects.h"
#include "core/sequence/sequence.h"
#include "core/sequence/stamps.h"
#include "evaluation/association/stamps.h"
#include "evaluation/object_solid.h"
#include "evaluation/world_alignment.h"
#include "harness/result/lengths.h"
#include "harness/result/pose_conventions.h"
#include "harness/result/stamp_units.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kMaxDifference_ns = 10'000'000;  // as evaluate has it
constexpr std::size_t kLeastPairs = 3;                  // for an alignment

// What is compared with: either may be missing.
struct Reference {
  std::optional<Sequence> sequence;
  std::optional<Tracks> truth;

  Trajectory camera() const {
    if (truth) return truth->camera;
    return sequence ? sequence->given_camera.value_or(Trajectory{}) : Trajectory{};
  }
};

std::string span_of(const std::vector<std::int64_t>& stamps_ns) {
  if (stamps_ns.empty()) return "";
  return fmt::format(", {} to {} s", format_stamp(stamps_ns.front()), format_stamp(stamps_ns.back()));
}

std::string rate_of(const std::vector<std::int64_t>& stamps_ns) {
  const std::int64_t period_ns = median_period_ns(stamps_ns);
  return period_ns > 0 ? fmt::format(", {:.3g} Hz", 1e9 / static_cast<double>(period_ns)) : "";
}

// Of the mesh that takes the place of the states' shapes.
std::string mesh_of(const fs::path& folder, int id) {
  const auto mesh = estimated_mesh(folder, id, 1, 0);
  return mesh ? fmt::format(", body: {} mesh of {:.3g} m^3", to_string(mesh->solid.kind()), mesh->volume_m3)
              : "";
}

std::string object_line(const fs::path& folder, const ObjectTrack& track) {
  const Eigen::Vector3d size_m = track.states.empty()
                                     ? Eigen::Vector3d::Zero().eval()
                                     : (2 * track.states.back().ellipsoid.semi_axes_m).eval();
  return fmt::format("object {}: {} states{}, size {:.3g} x {:.3g} x {:.3g} m{}\n", track.id,
                     track.states.size(), span_of(stamps_of(track.states)), size_m.x(), size_m.y(),
                     size_m.z(), mesh_of(folder, track.id));
}

std::string contents(const fs::path& folder, const Tracks& tracks) {
  require_tracks_of_solids(folder, tracks);
  const auto stamps_ns = stamps_of(tracks.camera);
  std::string text =
      fmt::format("camera: {} poses{}{}\n", stamps_ns.size(), span_of(stamps_ns), rate_of(stamps_ns));
  for (const ObjectTrack& track : tracks.objects) text += object_line(folder, track);
  std::string header;
  if (std::ifstream csv(folder / "objects.csv"); std::getline(csv, header))
    text += fmt::format("objects.csv: columns {}\n", header);
  return text;
}

// How many of these stamps lie at frames, and at how many frames.
struct AtFrames {
  std::size_t stamps = 0, matched = 0;
  std::set<std::size_t> frames;
};

AtFrames at_frames_of(const std::vector<std::int64_t>& stamps_ns,
                      const std::vector<std::int64_t>& frames_ns) {
  AtFrames found{stamps_ns.size(), 0, {}};
  const std::int64_t reach_ns = half_frame_ns(frames_ns);
  for (const std::int64_t stamp_ns : stamps_ns) {
    const std::size_t frame = nearest_index(frames_ns, stamp_ns);
    if (std::abs(frames_ns[frame] - stamp_ns) > reach_ns) continue;
    ++found.matched;
    found.frames.insert(frame);
  }
  return found;
}

std::string coverage(const AtFrames& found, std::size_t frames) {
  return fmt::format("{} of {} poses lie at {} of {} frames ({:.0f} %), {} are left out", found.matched,
                     found.stamps, found.frames.size(), frames,
                     100.0 * static_cast<double>(found.frames.size()) / static_cast<double>(frames),
                     found.stamps - found.matched);
}

// A line for the camera and one for each object: whether it is scored, and where.
std::string scored(const Tracks& tracks, const Reference& reference) {
  std::string text;
  const std::vector<std::int64_t> frames_ns =
      reference.sequence ? observed_ns(*reference.sequence) : std::vector<std::int64_t>{};
  const auto places = [&](const auto& list) {
    return frames_ns.empty() ? std::string("with the truth")
                             : coverage(at_frames_of(stamps_of(list), frames_ns), frames_ns.size());
  };
  text += tracks.camera.empty()
              ? std::string(
                    "not scored: camera (camera.tum has no poses); objects are compared where they stand\n")
              : fmt::format("scored: camera: {}\n", places(tracks.camera));
  for (const ObjectTrack& track : tracks.objects)
    text += fmt::format("scored: object {}: {}\n", track.id, places(track.states));
  if (tracks.objects.empty()) text += "not scored: objects (there are none)\n";
  return text;
}

void add_foreign_stamps(const fs::path& folder, const Tracks& tracks, const Sequence& sequence,
                        std::vector<std::string>& suspicions) {
  const auto frames_ns = observed_ns(sequence);
  const auto judge = [&](const fs::path& file, const std::vector<std::int64_t>& stamps_ns) {
    const AtFrames found = at_frames_of(stamps_ns, frames_ns);
    if (found.stamps > 0 && 2 * found.matched < found.stamps)
      suspicions.push_back(
          fmt::format("{}: stamps are not of the sequence: {} of {} lie at no frame of its {} to {} s",
                      file.string(), found.stamps - found.matched, found.stamps,
                      format_stamp(frames_ns.front()), format_stamp(frames_ns.back())));
  };
  judge(folder / "camera.tum", stamps_of(tracks.camera));
  for (const ObjectTrack& track : tracks.objects)
    judge(trajectory_file(folder, track.id), stamps_of(track.states));
}

Trajectory poses_of(const ObjectTrack& track) {
  Trajectory poses;
  for (const ObjectState& state : track.states)
    poses.push_back({state.stamp_ns, state.ellipsoid.world_from_object});
  return poses;
}

// Without a reference, by how each trajectory begins.
void add_first_quaternions(const fs::path& folder, const Tracks& tracks, const Reference& reference,
                           std::vector<std::string>& suspicions) {
  const auto add = [&](const fs::path& file, const Trajectory& trajectory) {
    if (const auto fault = first_quaternion_fault(trajectory))
      suspicions.push_back(file.string() + ": " + *fault);
  };
  if (reference.camera().empty()) add(folder / "camera.tum", tracks.camera);
  if (!reference.truth)
    for (const ObjectTrack& track : tracks.objects) add(trajectory_file(folder, track.id), poses_of(track));
}

// By the camera's poses, where there are enough of them.
WorldAlignment onto_world_of(const Tracks& truth, const Tracks& tracks) {
  const bool has_cameras = truth.camera.size() >= kLeastPairs && tracks.camera.size() >= kLeastPairs;
  const AlignmentKind kind = has_cameras ? AlignmentKind::poses : AlignmentKind::none;
  return align_world(kind, truth, tracks, kMaxDifference_ns);
}

void add_objects(const fs::path& folder, const Tracks& tracks, const Tracks& truth,
                 std::vector<std::string>& suspicions) {
  const WorldAlignment alignment = onto_world_of(truth, tracks);
  const Pose& truth_from_estimate = alignment.truth_from_estimate.reference_from_estimate;
  const Tracks placed = in_true_world(alignment, tracks);
  for (const auto& [object, track] : matched_tracks(truth, placed)) {
    const auto as_read = std::ranges::find(tracks.objects, track->id, &ObjectTrack::id);
    if (const auto fault =
            object_convention_fault(poses_of(*object), poses_of(*as_read), truth_from_estimate))
      suspicions.push_back(trajectory_file(folder, track->id).string() + ": " + *fault);
  }
  if (const auto fault = size_faults(folder, placed, truth)) suspicions.push_back(*fault);
}

std::vector<std::string> suspicions_of(const fs::path& folder, const Tracks& tracks,
                                       const Reference& reference) {
  const Tracks* truth = reference.truth ? &*reference.truth : nullptr;
  const Trajectory camera = reference.camera();
  std::vector<std::string> suspicions = unit_faults(folder, tracks, camera, truth);
  if (reference.sequence) add_foreign_stamps(folder, tracks, *reference.sequence, suspicions);
  add_first_quaternions(folder, tracks, reference, suspicions);
  const auto fault = camera_convention_fault(camera, tracks.camera);
  if (fault) suspicions.push_back((folder / "camera.tum").string() + ": " + *fault);
  // a camera in another unit or convention carries the objects to no world
  if (truth && suspicions.empty()) add_objects(folder, tracks, *truth, suspicions);
  return suspicions;
}

}  // namespace

ResultCheck check_result(const fs::path& folder, const fs::path& sequence, const fs::path& truth) {
  const std::vector<std::string> units =
      fs::is_directory(folder) ? stamp_unit_faults(folder) : std::vector<std::string>{};
  Reference reference;
  if (!sequence.empty()) reference.sequence = open_sequence(sequence);
  if (!truth.empty()) reference.truth = read_tracks(truth);
  Tracks tracks;
  try {
    tracks = read_tracks(folder);
  } catch (const InputError& error) {
    if (units.empty()) throw;
    throw InputError(fmt::format("{} ({})", error.what(), units.front()));
  }
  ResultCheck check{contents(folder, tracks) + scored(tracks, reference), units};
  if (units.empty()) check.suspicions = suspicions_of(folder, tracks, reference);
  return check;
}

}  // namespace uniquadric
