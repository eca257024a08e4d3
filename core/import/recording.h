#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/sequence/calibration.h"
#include "core/sequence/ply.h"
#include "core/sequence/sequence.h"
#include "core/sequence/stamps.h"

namespace uniquadric {

/// An image of a recording and its place in the sequence.
struct RecordedImage {
  std::filesystem::path source;  ///< in the recording
  std::filesystem::path target;  ///< relative to the sequence folder
  ImageKind kind = ImageKind::color;
  /// The sequence's image, made of `source`; nothing (or no function) where the file itself is copied.
  std::function<std::optional<cv::Mat>(const std::filesystem::path&)> make{};
};

/// What a recording knows of the truth.
struct RecordedTruth {
  Trajectory camera;                       ///< world_from_camera at stamps of frames
  std::vector<ObjectDescription> objects;  ///< may be none
  std::map<int, Trajectory> objects_at;    ///< world_from_object by id, at stamps of `camera`
  /// Reads an object's mesh [m, in its frame] by id; of some objects alone.
  std::map<int, std::function<SurfaceFile()>> meshes{};
  TruthNotes notes{};
};

/// A recording to import, whatever its layout: every reader returns one, and write_recording() writes it.
struct Recording {
  Sequence sequence;  ///< as it will be written: its files' paths are those in the new folder
  std::vector<RecordedImage> images;
  std::vector<ImuSample> imu;                                               ///< of sequence.imu
  std::function<std::vector<LidarPoint>(const SequenceScan&)> read_scan{};  ///< of sequence.scans
  std::optional<RecordedTruth> truth;
  bool is_sequence_alone = false;  ///< OUT is the sequence folder; else OUT/sequence and, of truth, OUT/truth
  std::vector<std::string> left_out;  ///< what was not taken and why, a line each
  /// The same of the scans, once they were read.
  std::function<std::vector<std::string>()> left_out_of_scans{};
};

struct ImportOptions {
  bool quiet = false;
  bool force = false;  ///< replace an existing output folder
};

/// Checks the images, writes all, says on stderr what is left out. Throws InputError for images that cannot
/// be used, by their names in the recording; then nothing is left at `out`.
void write_recording(const Recording& recording, const ImportOptions& options,
                     const std::filesystem::path& out);

/// A sequence of that recording without frames: its program and name.
Sequence begin_sequence(const std::string& name);
/// Appends a frame with its colour image; stamps must come in increasing order.
SequenceFrame& add_frame(Sequence& sequence, std::int64_t stamp_ns, const std::filesystem::path& rgb);

/// A camera pose is interpolated only between ground-truth poses no further apart than this.
inline constexpr double kMaxPoseGap_s =
    0.1;  // ours: motion capture comes at 100 Hz or more; 0.1 s of it missing is an outage

/// The poses at those stamps: exact where a pose has the stamp, interpolated between poses no further apart
/// than `max_gap_s`, absent elsewhere.
Trajectory trajectory_at(const Trajectory& trajectory, const std::vector<std::int64_t>& stamps_ns,
                         double max_gap_s = kMaxPoseGap_s);

/// trajectory_at() the recording's frames, of poses that stand in `file`; adds to `left_out` how many frames
/// have none. Throws InputError where none has one: poses of another clock, for which `remedy` may name an
/// option.
Trajectory camera_poses(const std::filesystem::path& file, const Trajectory& world_from_camera,
                        Recording& recording, double max_gap_s = kMaxPoseGap_s,
                        const std::string& remedy = "");

/// A name for a recording that is plain in files: that of its folder, with _ for what is none of letters,
/// digits and _-. ; `recording` where the folder has no name.
std::string recording_name(const std::filesystem::path& recording);

/// One over the median interval of stamps in increasing order; `fallback_hz` for fewer than two.
double nominal_rate_hz(const std::vector<std::int64_t>& stamps_ns, double fallback_hz);

}  // namespace uniquadric
