#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/imu.h"
#include "core/sequence/lidar.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {

/// Files of one camera frame; depth and masks are empty paths where the frame has none.
struct SequenceFrame {
  std::int64_t frame = 0;                   ///< place in rgb.txt, from 0
  std::int64_t stamp_ns = 0;                ///< of the colour image
  std::filesystem::path rgb, depth, masks;  ///< relative to the sequence folder
  std::int64_t masks_arrival_ns = 0;        ///< when the segmenter's result is there (stamp + latency)
};

/// File of one LiDAR scan, whose points' times count from the stamp.
struct SequenceScan {
  std::int64_t stamp_ns = 0;   ///< start of the scan
  std::filesystem::path file;  ///< relative to the sequence folder
};

/// A sequence folder: observations and calibration, nothing of the truth. Layout in docs/formats.md.
struct Sequence {
  std::filesystem::path folder;
  std::string program;     ///< that made it, with version
  std::string name;        ///< of the scene or recording
  std::string scene_hash;  ///< empty for recordings
  std::uint64_t seed = 0;
  std::string realism;  ///< level of the sensors' errors that the scene names (ideal, mild, ...); else empty
  Camera camera;
  double rate_hz = 0;                     ///< nominal frame rate
  double rolling_shutter_s = 0;           ///< from a colour image's first row to its last; stamp: the middle
  double depth_units_per_m = 5000;        ///< value of a depth pixel at 1 m
  double inverse_depth_bias_per_m = 0;    ///< that depth images have, as estimated; not in any file
  double depth_edge_width_px = 1;         ///< of ramps that depth images make of steps: read_depth drops them
  std::optional<ImuCalibration> imu;      ///< of imu.csv, when there is one
  std::optional<LidarCalibration> lidar;  ///< of the scans, when there are any
  std::vector<SequenceScan> scans;        ///< in strictly increasing order of stamps
  std::vector<SequenceFrame> frames;      ///< in strictly increasing order of stamps
  std::optional<Trajectory> given_camera;  ///< world_from_camera from another system (camera_given.tum)
};

/// Opens a sequence folder and checks it: schema, lists, stamps, that every file named exists. Throws
/// InputError.
Sequence open_sequence(const std::filesystem::path& folder);

/// Writes sequence.yaml, rgb.txt, depth.txt, masks.txt and camera_given.tum into `folder` (images are the
/// caller's).
void write_sequence_index(const std::filesystem::path& folder, const Sequence& sequence);

/// Colour as CV_8UC3 in OpenCV's order (blue, green, red). Readers throw InputError naming the file for
/// images that are unreadable, truncated, of the wrong type or not of the camera's size.
cv::Mat read_rgb(const Sequence& sequence, const SequenceFrame& frame);
/// Depth as CV_32FC1: z along the optical axis [m], 0 where there is none, which the file says by 0 or by the
/// largest number that it can hold: there a sensor gave up, or a depth was cut off. The
/// bias of inverse depth is taken out: z = measured / (1 - bias * measured).
inline constexpr int kDepthCutOff = 65535;
cv::Mat read_depth(const Sequence& sequence, const SequenceFrame& frame);
/// Instance masks as CV_16UC1: 0 is background. More than kMostIds others are no masks.
inline constexpr int kMostIds = 256;  // ours: more are noise, or an image of another kind
cv::Mat read_masks(const Sequence& sequence, const SequenceFrame& frame);

/// What an image of a sequence is: 8-bit colour, 16-bit depth, 16-bit ids.
enum class ImageKind { color, depth, masks };
/// Throws InputError naming the file for an image that is not of that kind, or not of the camera's size.
void require_image(const std::filesystem::path& path, const cv::Mat& image, const Camera& camera,
                   ImageKind kind);

/// Any PNG or JPEG (image_file.h), undecodable or truncated files refused with InputError.
cv::Mat read_image(const std::filesystem::path& path);
/// Writes a PNG (fast compression), aside and renamed.
void write_png(const std::filesystem::path& path, const cv::Mat& image);

}  // namespace uniquadric
