#pragma once

#include <cstdint>
#include <filesystem>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string_view>
#include <vector>

#include "core/sequence/calibration.h"
#include "core/sequence/sequence.h"
#include "core/sequence/tracks.h"
#include "core/sequence/visibility.h"

namespace uniquadric {

struct ExportTruth {
  std::filesystem::path folder;
  Tracks tracks;
  std::vector<ObjectDescription> objects;
  VisibilityTable visibility;
};

/// What is exported: a sequence and, where it is known, its truth.
struct ExportSource {
  Sequence sequence;
  std::optional<ExportTruth> truth;
};

/// Opens both; `truth_folder` empty: the sibling folder `truth` when there is one. Throws InputError.
ExportSource open_export_source(const std::filesystem::path& sequence_folder,
                                const std::filesystem::path& truth_folder);

/// Throws InputError naming the sequence when it has no images, which `what` needs.
void require_images(const Sequence& sequence, std::string_view what);

/// The pose at exactly that stamp.
std::optional<Pose> pose_at_stamp(const Trajectory& trajectory, std::int64_t stamp_ns);

/// world_from_camera at a frame: the truth's, else the given one, else nothing.
std::optional<Pose> camera_pose(const ExportSource& source, const SequenceFrame& frame);

/// world_from_camera of all frames that have one.
Trajectory camera_poses(const ExportSource& source);

/// An object of the truth at one frame.
struct ObjectAtFrame {
  const ObjectDescription* object = nullptr;
  Pose camera_from_object;
  ObjectVisibility visibility;
};
/// The objects whose poses the truth knows at a frame, in order of ids; none without truth.
std::vector<ObjectAtFrame> objects_at(const ExportSource& source, const SequenceFrame& frame);

/// The truth's exact instance mask of a frame: 16UC1, 0 is background. Throws InputError when it is missing
/// or not of the camera's size.
cv::Mat read_instances(const ExportSource& source, const SequenceFrame& frame);

/// Writes a frame's colour image as PNG after checking it: byte for byte the sequence's file when that is a
/// PNG and nothing is to be rectified.
void write_color_png(const ExportSource& source, const SequenceFrame& frame, bool rectified,
                     const std::filesystem::path& path);

/// Smallest rectangle around the pixels of an id in a 16UC1 mask: [u_min, v_min, u_max, v_max], inclusive;
/// nothing when there is none.
struct PixelBox {
  int u_min, v_min, u_max, v_max;
};
std::optional<PixelBox> box_of_id(const cv::Mat& ids, int id);

/// The eight corners of the object's tight box in the camera frame [m], a column each.
Eigen::Matrix<double, 3, 8> box_corners(const ObjectAtFrame& object);

}  // namespace uniquadric
