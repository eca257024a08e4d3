#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/core.hpp>
#include <set>

#include "core/base/error.h"
#include "core/sequence/pcd.h"
#include "core/sequence/tracks.h"
#include "harness/check.h"
#include "harness/export/export_source.h"
#include "simulator/noise/mask_faults.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Problems = std::vector<std::string>;

void add(Problems& problems, const fs::path& path, const std::string& what) {
  problems.push_back(path.string() + ": " + what);
}

// The frames of a simulation are the truth's; a recording's truth may know some of them alone.
void check_stamps(const ExportSource& source, Problems& problems) {
  std::set<std::int64_t> frames;
  for (const SequenceFrame& frame : source.sequence.frames) frames.insert(frame.stamp_ns);
  if (frames.empty()) return;
  const bool is_recording = source.sequence.scene_hash.empty();
  const auto differs = [&](const auto& states) {
    return (!is_recording && states.size() != frames.size()) ||
           std::any_of(states.begin(), states.end(),
                       [&](const auto& state) { return !frames.contains(state.stamp_ns); });
  };
  const char* const what =
      is_recording ? "has other frames than the sequence" : "does not have the sequence's frames";
  const ExportTruth& truth = *source.truth;
  if (differs(truth.tracks.camera)) add(problems, truth.folder / "camera.tum", what);
  for (const ObjectTrack& track : truth.tracks.objects)
    if (differs(track.states)) add(problems, truth.folder / fmt::format("objects/{}.tum", track.id), what);
}

// Simulated sensors may be told their calibration a little wrong (scenes/realism.md): both focal lengths by
// one factor, and the principal point.
bool is_told_a_little_wrong(const Camera& camera, const Camera& truth) {
  constexpr double kFocal = 0.03, kCentre = 0.03, kSameFactor = 1e-6;  // relative; of the width
  const double fx = camera.fx / truth.fx, fy = camera.fy / truth.fy;
  return fx != 1 && std::abs(fx - 1) <= kFocal && std::abs(fx - fy) <= kSameFactor &&
         std::abs(camera.cx - truth.cx) <= kCentre * truth.width &&
         std::abs(camera.cy - truth.cy) <= kCentre * truth.width && camera.distortion == truth.distortion &&
         camera.width == truth.width && camera.height == truth.height;
}

void check_calibration(const ExportSource& source, Problems& problems) {
  const auto& calibration = source.truth->tracks.calibration;
  const Camera& camera = source.sequence.camera;
  if (calibration &&
      (calibration->width != camera.width || calibration->height != camera.height ||
       calibration->matrix() != camera.matrix() || calibration->distortion != camera.distortion) &&
      !is_told_a_little_wrong(camera, *calibration))
    add(problems, source.truth->folder / "camera.yaml", "is not the sequence's calibration");
}

// `last`: ids from here on are a simulated segmenter's false ones.
void check_ids(const fs::path& path, const std::map<int, int>& pixels, const std::set<int>& known,
               Problems& problems, int last = std::numeric_limits<int>::max()) {
  for (const auto& [id, count] : pixels)
    if (!known.contains(id) && id < last)
      add(problems, path, fmt::format("{} pixels are of object {}, which is unknown", count, id));
}

void check_instances(const ExportSource& source, const SequenceFrame& frame, const std::set<int>& known,
                     Problems& problems) {
  const fs::path folder = source.truth->folder / "instances";
  const std::map<int, int> pixels = count_ids(read_instances(source, frame));
  check_ids(folder / fmt::format("{:06}.png", frame.frame), pixels, known, problems);
  for (const int id : known) {
    const auto row = source.truth->visibility.find({frame.frame, id});
    if (row == source.truth->visibility.end()) {
      add(problems, folder / "visibility.csv",
          fmt::format("has no row for frame {}, object {}", frame.frame, id));
      continue;
    }
    const int visible = pixels.contains(id) ? pixels.at(id) : 0;
    if (row->second.visible_px != visible || row->second.silhouette_px < visible)
      add(problems, folder / "visibility.csv",
          fmt::format("frame {}, object {}: {} of {} pixels, the mask has {}", frame.frame, id,
                      row->second.visible_px, row->second.silhouette_px, visible));
  }
}

void check_masks(const ExportSource& source, Problems& problems) {
  std::set<int> known;
  for (const ObjectDescription& object : source.truth->objects) known.insert(object.id);
  for (const SequenceFrame& frame : source.sequence.frames) try {
      check_instances(source, frame, known, problems);
      if (!frame.masks.empty())
        check_ids(source.sequence.folder / frame.masks, count_ids(read_masks(source.sequence, frame)), known,
                  problems, kFirstFalseId);
    } catch (const InputError& e) {  // an image that cannot be read: the others still can
      problems.push_back(e.what());
    }
}

// Each scan's truth speaks of the same points.
void check_scans(const ExportSource& source, Problems& problems) {
  for (const SequenceScan& scan : source.sequence.scans) {
    const fs::path path = source.truth->folder / "lidar" / scan.file.filename();
    if (!fs::exists(path)) {
      add(problems, path, "is missing");
      continue;
    }
    const auto points = read_pcd(source.sequence.folder / scan.file).points, truth = read_pcd(path).points;
    if (points != truth) add(problems, path, fmt::format("has {} points, the scan {}", truth, points));
  }
}

}  // namespace

void check_truth(const Sequence& sequence, const fs::path& folder, std::vector<std::string>& problems) {
  const ExportSource source = open_export_source(sequence.folder, folder);
  check_stamps(source, problems);
  check_calibration(source, problems);
  if (fs::is_directory(folder / "instances")) check_masks(source, problems);
  if (fs::is_directory(folder / "lidar")) check_scans(source, problems);
}

}  // namespace uniquadric
