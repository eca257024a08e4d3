#include "harness/export/export_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/files.h"
#include "core/import/rectify.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

ExportTruth open_truth(const fs::path& folder) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  ExportTruth truth;
  truth.folder = folder;
  truth.tracks = read_tracks(folder);
  truth.objects = read_objects_yaml(folder / "objects.yaml");
  if (fs::is_directory(folder / "instances"))  // labels come without
    truth.visibility = read_visibility(folder / "instances/visibility.csv");
  return truth;
}

}  // namespace

ExportSource open_export_source(const fs::path& sequence_folder, const fs::path& truth_folder) {
  ExportSource source{open_sequence(sequence_folder), std::nullopt};
  const fs::path sibling = fs::weakly_canonical(source.sequence.folder).parent_path() / "truth";
  if (!truth_folder.empty())
    source.truth = open_truth(truth_folder);
  else if (fs::is_directory(sibling))
    source.truth = open_truth(sibling);
  return source;
}

void require_images(const Sequence& sequence, std::string_view what) {
  if (sequence.frames.empty())
    throw InputError(sequence.folder, fmt::format("has no images, which {} needs", what));
}

std::optional<Pose> pose_at_stamp(const Trajectory& trajectory, std::int64_t stamp_ns) {
  const auto found = std::lower_bound(trajectory.begin(), trajectory.end(), stamp_ns,
                                      [](const StampedPose& p, std::int64_t t) { return p.stamp_ns < t; });
  if (found == trajectory.end() || found->stamp_ns != stamp_ns) return std::nullopt;
  return found->pose;
}

std::optional<Pose> camera_pose(const ExportSource& source, const SequenceFrame& frame) {
  if (source.truth) return pose_at_stamp(source.truth->tracks.camera, frame.stamp_ns);
  if (source.sequence.given_camera) return pose_at_stamp(*source.sequence.given_camera, frame.stamp_ns);
  return std::nullopt;
}

Trajectory camera_poses(const ExportSource& source) {
  Trajectory poses;
  for (const SequenceFrame& frame : source.sequence.frames)
    if (const auto pose = camera_pose(source, frame)) poses.push_back({frame.stamp_ns, *pose});
  return poses;
}

std::vector<ObjectAtFrame> objects_at(const ExportSource& source, const SequenceFrame& frame) {
  const auto world_from_camera = camera_pose(source, frame);
  if (!source.truth || !world_from_camera) return {};
  std::vector<ObjectAtFrame> objects;
  for (const ObjectTrack& track : source.truth->tracks.objects) {
    const auto state = std::find_if(track.states.begin(), track.states.end(),
                                    [&](const ObjectState& s) { return s.stamp_ns == frame.stamp_ns; });
    const auto description = std::find_if(source.truth->objects.begin(), source.truth->objects.end(),
                                          [&](const ObjectDescription& o) { return o.id == track.id; });
    if (state == track.states.end() || description == source.truth->objects.end()) continue;
    const auto visibility = source.truth->visibility.find({frame.frame, track.id});
    objects.push_back(
        {&*description, world_from_camera->inverse() * state->ellipsoid.world_from_object,
         visibility == source.truth->visibility.end() ? ObjectVisibility{} : visibility->second});
  }
  return objects;
}

cv::Mat read_instances(const ExportSource& source, const SequenceFrame& frame) {
  const fs::path path = source.truth->folder / "instances" / fmt::format("{:06}.png", frame.frame);
  const cv::Mat ids = read_image(path);
  const Camera& camera = source.sequence.camera;
  if (ids.type() != CV_16UC1) throw InputError(path, "expected a 16-bit grey image");
  if (ids.cols != camera.width || ids.rows != camera.height)
    throw InputError(path, fmt::format("is {}x{}, the camera says {}x{}", ids.cols, ids.rows, camera.width,
                                       camera.height));
  return ids;
}

void write_color_png(const ExportSource& source, const SequenceFrame& frame, bool rectified,
                     const fs::path& path) {
  const cv::Mat color = read_rgb(source.sequence, frame);
  const bool changes = rectified && source.sequence.camera.has_distortion();
  if (frame.rgb.extension() == ".png" && !changes)
    duplicate_file(source.sequence.folder / frame.rgb, path);
  else
    write_png(path, changes ? rectify(source.sequence.camera, color, true) : color);
}

std::optional<PixelBox> box_of_id(const cv::Mat& ids, int id) {
  const cv::Rect box = cv::boundingRect(ids == id);
  if (box.area() == 0) return std::nullopt;
  return PixelBox{box.x, box.y, box.x + box.width - 1, box.y + box.height - 1};
}

Eigen::Matrix<double, 3, 8> box_corners(const ObjectAtFrame& object) {
  Eigen::Matrix<double, 3, 8> corners;
  for (int i = 0; i < 8; ++i)
    corners.col(i) = object.camera_from_object *
                     object.object->semi_axes_m
                         .cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1))
                         .eval();
  return corners;
}

}  // namespace uniquadric
