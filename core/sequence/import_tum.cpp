#include "core/sequence/import_tum.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/progress.h"
#include "core/base/version.h"
#include "core/sequence/calibration.h"
#include "core/sequence/file_list.h"
#include "core/sequence/recording.h"
#include "core/sequence/sequence.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kBenchmarkRateHz = 30;  // of its cameras: one image has no rate

void read_calibration(const fs::path& path, Sequence& sequence) {
  const ConfigNode node = ConfigNode::load(path);
  sequence.camera = read_camera(node);
  sequence.depth_units_per_m = node.positive("depth_units_per_metre");
  node.refuse_unknown_keys();
}

std::vector<std::int64_t> stamps_of(const std::vector<SequenceFrame>& frames) {
  std::vector<std::int64_t> stamps_ns;
  for (const SequenceFrame& frame : frames) stamps_ns.push_back(frame.stamp_ns);
  return stamps_ns;
}

// The pose at a stamp; nothing outside the trajectory's span or within a gap that is too long.
std::optional<Pose> pose_at(const Trajectory& trajectory, std::int64_t stamp_ns, double max_gap_s) {
  const auto after =
      std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                       [](const StampedPose& pose, std::int64_t stamp) { return pose.stamp_ns < stamp; });
  if (after == trajectory.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == trajectory.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  const auto gap_ns = static_cast<double>(after->stamp_ns - before.stamp_ns);
  if (gap_ns > max_gap_s * 1e9) return std::nullopt;
  Pose pose = interpolate(before.pose, after->pose, static_cast<double>(stamp_ns - before.stamp_ns) / gap_ns);
  pose.rotation.normalize();
  return pose;
}

void refuse_paths_outside(const fs::path& recording, const std::string& list,
                          const std::vector<ListedFile>& files) {
  for (const auto& entry : files)
    if (entry.file.is_absolute() || std::find(entry.file.begin(), entry.file.end(), "..") != entry.file.end())
      throw InputError(recording / list, fmt::format("{} leads out of the recording", entry.file.string()));
}

Sequence describe(const fs::path& recording, const ImportTumOptions& options) {
  Sequence sequence;
  sequence.folder = recording;
  sequence.program = kProgram;
  sequence.name = recording_name(recording);
  read_calibration(options.camera.empty() ? recording / "camera.yaml" : options.camera, sequence);
  const auto rgb = read_file_list(recording, "rgb.txt", false);
  const auto depth = read_file_list(recording, "depth.txt", false);
  if (rgb.empty()) throw InputError(recording / "rgb.txt", "names no image");
  refuse_paths_outside(recording, "rgb.txt", rgb);
  refuse_paths_outside(recording, "depth.txt", depth);
  for (const auto& entry : rgb) {
    SequenceFrame frame;
    frame.frame = std::ssize(sequence.frames);
    frame.stamp_ns = entry.stamp_ns;
    frame.rgb = entry.file;
    sequence.frames.push_back(frame);
  }
  associate_depth(sequence.frames, depth);
  sequence.rate_hz = nominal_rate_hz(stamps_of(sequence.frames), kBenchmarkRateHz);
  if (!fs::exists(recording / "groundtruth.txt")) return sequence;
  const Trajectory truth = read_tum(recording / "groundtruth.txt");
  sequence.given_camera.emplace();
  for (const auto& frame : sequence.frames)
    if (const auto pose = pose_at(truth, frame.stamp_ns, options.max_pose_gap_s))
      sequence.given_camera->push_back({frame.stamp_ns, *pose});
  return sequence;
}

void copy_checked(const Sequence& sequence, const SequenceFrame& frame, const fs::path& out) {
  read_rgb(sequence, frame);  // throws for images that cannot be used
  if (!frame.depth.empty()) read_depth(sequence, frame);
  for (const fs::path& file : {frame.rgb, frame.depth}) {
    if (file.empty()) continue;
    fs::create_directories((out / file).parent_path());
    if (!fs::exists(out / file)) duplicate_file(sequence.folder / file, out / file);
  }
}

}  // namespace

void import_tum(const fs::path& recording, const ImportTumOptions& options, const fs::path& out) {
  if (!fs::is_directory(recording)) throw InputError(recording, "is not a folder");
  const Sequence sequence = describe(recording, options);
  PendingFolder pending(out, options.force);
  Progress progress("import", std::ssize(sequence.frames), options.quiet);
  for (const auto& frame : sequence.frames) {
    copy_checked(sequence, frame, pending.path());
    progress.advance();
  }
  write_sequence_index(pending.path(), sequence);
  pending.commit();
}

}  // namespace uniquadric
