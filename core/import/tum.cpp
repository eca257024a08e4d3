#include "core/import/tum.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/sequence/file_list.h"

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

std::vector<ListedFile> read_list(const fs::path& recording, const std::string& list) {
  auto files = read_file_list(recording, list, false);
  if (files.empty()) throw InputError(recording / list, "names no image");
  return files;
}

// What hardly ever lies beside the other list is of another clock or in another unit.
void require_common_clock(const fs::path& file, std::size_t depth, const std::vector<SequenceFrame>& frames) {
  constexpr std::size_t kLeastShare = 10;  // ours: one in ten
  const auto both = static_cast<std::size_t>(
      std::count_if(frames.begin(), frames.end(), [](const SequenceFrame& f) { return !f.depth.empty(); }));
  if (both * kLeastShare < std::min(depth, frames.size()))
    throw InputError(file, fmt::format("{} of {} depth images lie within 0.02 s of one of the {} of rgb.txt: "
                                       "stamps of both are in seconds, of one clock",
                                       both, depth, frames.size()));
}

Recording read_recording(const fs::path& folder, const ImportTumOptions& options) {
  Recording recording;
  recording.is_sequence_alone = true;
  Sequence& sequence = recording.sequence = begin_sequence(recording_name(folder));
  read_calibration(options.camera.empty() ? folder / "camera.yaml" : options.camera, sequence);
  const auto rgb = read_list(folder, "rgb.txt"), depth = read_list(folder, "depth.txt");
  for (const ListedFile& entry : rgb) add_frame(sequence, entry.stamp_ns, entry.file);
  associate_depth(sequence.frames, depth);
  require_common_clock(folder / "depth.txt", depth.size(), sequence.frames);
  for (const SequenceFrame& frame : sequence.frames) {
    recording.images.push_back({folder / frame.rgb, frame.rgb, ImageKind::color});
    if (!frame.depth.empty())
      recording.images.push_back({folder / frame.depth, frame.depth, ImageKind::depth});
  }
  sequence.rate_hz = nominal_rate_hz(stamps_of(sequence.frames), kBenchmarkRateHz);
  if (const fs::path truth = folder / "groundtruth.txt"; fs::exists(truth))
    sequence.given_camera = camera_poses(truth, read_tum(truth), recording, options.max_pose_gap_s);
  return recording;
}

}  // namespace

void import_tum(const fs::path& recording, const ImportTumOptions& options, const fs::path& out) {
  if (!fs::is_directory(recording)) throw InputError(recording, "is not a folder");
  write_recording(read_recording(recording, options), options, out);
}

}  // namespace uniquadric
