#include "core/import/recording.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <iostream>
#include <utility>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/base/folder_hashes.h"
#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/version.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

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

void write_image(const Recording& recording, const RecordedImage& image, const fs::path& folder) {
  const std::optional<cv::Mat> made = image.make ? image.make(image.source) : std::nullopt;
  require_image(image.source, made ? *made : read_image(image.source), recording.sequence.camera, image.kind);
  const fs::path target = folder / image.target;
  fs::create_directories(target.parent_path());
  if (made)
    write_png(target, *made);
  else if (!fs::exists(target))  // one file may serve several frames
    duplicate_file(image.source, target);
}

void write_sequence(const Recording& recording, const ImportOptions& options, const fs::path& folder) {
  const Sequence& sequence = recording.sequence;
  fs::create_directories(folder);
  Progress progress("import", std::ssize(recording.images) + std::ssize(sequence.scans), options.quiet);
  for (const RecordedImage& image : recording.images) {
    write_image(recording, image, folder);
    progress.advance();
  }
  for (const SequenceScan& scan : sequence.scans) {
    fs::create_directories((folder / scan.file).parent_path());
    write_lidar_points(folder / scan.file, recording.read_scan(scan));
    progress.advance();
  }
  if (sequence.imu) write_imu_csv(folder / "imu.csv", recording.imu);
  write_sequence_index(folder, sequence);
  write_hashes(folder);
}

void write_truth(const RecordedTruth& truth, const Camera& camera, const fs::path& folder) {
  fs::create_directories(folder / "objects");
  for (const auto& [id, trajectory] : truth.objects_at)
    write_tum(folder / fmt::format("objects/{}.tum", id), trajectory);
  for (const auto& [id, read_mesh] : truth.meshes)
    write_surface_ply(folder / fmt::format("objects/{}.ply", id), read_mesh(), kProgram);
  write_objects_yaml(folder / "objects.yaml", truth.objects, "", truth.notes);
  write_tum(folder / "camera.tum", truth.camera);
  write_camera_yaml(folder / "camera.yaml", camera);
  write_hashes(folder);
}

}  // namespace

void write_recording(const Recording& recording, const ImportOptions& options, const fs::path& out) {
  PendingFolder pending(out, "recording", options.force);
  if (recording.is_sequence_alone) {
    write_sequence(recording, options, pending.path());
  } else {
    write_sequence(recording, options, pending.path() / "sequence");
    if (recording.truth) write_truth(*recording.truth, recording.sequence.camera, pending.path() / "truth");
  }
  pending.commit();
  std::vector<std::string> left_out = recording.left_out;
  if (recording.left_out_of_scans)
    for (std::string& what : recording.left_out_of_scans()) left_out.push_back(std::move(what));
  for (const std::string& what : left_out) std::cerr << "uniquadric: " << what << '\n';
}

Sequence begin_sequence(const std::string& name) {
  Sequence sequence;
  sequence.program = kProgram;
  sequence.name = name;
  return sequence;
}

SequenceFrame& add_frame(Sequence& sequence, std::int64_t stamp_ns, const fs::path& rgb) {
  SequenceFrame frame;
  frame.frame = std::ssize(sequence.frames);
  frame.stamp_ns = stamp_ns;
  frame.rgb = rgb;
  return sequence.frames.emplace_back(frame);
}

Trajectory trajectory_at(const Trajectory& trajectory, const std::vector<std::int64_t>& stamps_ns,
                         double max_gap_s) {
  Trajectory result;
  for (const std::int64_t stamp_ns : stamps_ns)
    if (const auto pose = pose_at(trajectory, stamp_ns, max_gap_s)) result.push_back({stamp_ns, *pose});
  return result;
}

Trajectory camera_poses(const fs::path& file, const Trajectory& world_from_camera, Recording& recording,
                        double max_gap_s, const std::string& remedy) {
  if (world_from_camera.empty()) throw InputError(file, "holds no pose");
  const auto stamps_ns = stamps_of(recording.sequence.frames);
  Trajectory poses = trajectory_at(world_from_camera, stamps_ns, max_gap_s);
  const bool apart = stamps_ns.back() < world_from_camera.front().stamp_ns ||
                     stamps_ns.front() > world_from_camera.back().stamp_ns;
  if (poses.empty() && apart)
    throw InputError(file, "no image lies within the poses' times: the clocks differ" + remedy);
  if (poses.empty())
    throw InputError(file,
                     fmt::format("all images lie in holes of more than {} s between the poses", max_gap_s));
  if (poses.size() < stamps_ns.size())
    recording.left_out.push_back(
        fmt::format("{}: {} of {} images have no pose, outside its times or in a hole of more than {} s",
                    file.string(), stamps_ns.size() - poses.size(), stamps_ns.size(), max_gap_s));
  return poses;
}

std::string recording_name(const fs::path& recording) {
  const fs::path folder = fs::weakly_canonical(recording);
  std::string name = (folder.has_filename() ? folder : folder.parent_path()).filename().string();
  const auto is_plain = [](unsigned char c) { return std::isalnum(c) || c == '_' || c == '-' || c == '.'; };
  std::replace_if(name.begin(), name.end(), std::not_fn(is_plain), '_');
  return name.empty() ? "recording" : name;
}

double nominal_rate_hz(const std::vector<std::int64_t>& stamps_ns, double fallback_hz) {
  std::vector<std::int64_t> intervals_ns;
  for (std::size_t i = 1; i < stamps_ns.size(); ++i) intervals_ns.push_back(stamps_ns[i] - stamps_ns[i - 1]);
  if (intervals_ns.empty()) return fallback_hz;
  return 1e9 / static_cast<double>(upper_median(std::move(intervals_ns)));
}

}  // namespace uniquadric
