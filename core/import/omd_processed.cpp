#include <fmt/format.h>

#include <limits>
#include <opencv2/core.hpp>

#include "core/base/config.h"
#include "core/base/error.h"
#include "core/base/read_file.h"
#include "core/base/text.h"
#include "core/import/fields.h"
#include "core/import/images.h"
#include "core/import/omd_readers.h"
#include "core/import/pinhole.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr double kBf = 387.5744, kDisparityUnits = 1000;  // where the settings do not say them
constexpr double kDepthUnitsPerM = 1000, kCameraRateHz = 30;
constexpr std::int64_t kIds = std::numeric_limits<std::uint16_t>::max() + 1;
constexpr std::size_t kCameraFields = 17, kObjectFields = 8;

fs::path settings_file(const fs::path& recording, const fs::path& wanted) {
  if (!wanted.empty()) return wanted;
  std::vector<fs::path> found;
  for (const auto& entry : fs::directory_iterator(recording))
    if (entry.path().extension() == ".yaml") found.push_back(entry.path());
  if (found.size() != 1)
    throw InputError(recording,
                     fmt::format("has {} files .yaml, expected one with the settings Camera.fx, ...: "
                                 "--calibration",
                                 found.size()));
  return found.front();
}

// OpenCV's files begin with %YAML:1.0, which is no YAML.
ConfigNode load_settings(const fs::path& path) {
  std::string text = read_file(path, kYamlFile);
  if (text.starts_with("%YAML")) text[0] = '#';
  return ConfigNode::parse(text, path);
}

// Text of ids, a line a row of the image.
cv::Mat read_ids(const fs::path& path, const Camera& camera) {
  cv::Mat ids(camera.height, camera.width, CV_16UC1);
  int row = 0;
  for_each_line(path, [&](int line, const Fields& fields) {
    if (row >= camera.height || static_cast<int>(fields.size()) != camera.width)
      throw InputError(path, line,
                       row >= camera.height
                           ? fmt::format("expected {} rows", camera.height)
                           : fmt::format("expected {} ids, found {}", camera.width, fields.size()));
    for (int u = 0; u < camera.width; ++u)
      ids.at<std::uint16_t>(row, u) =
          static_cast<std::uint16_t>(read_count(path, line, fields[u], "id", kIds));
    ++row;
  });
  if (row < camera.height)
    throw InputError(path, fmt::format("has {} rows of ids, the camera {}", row, camera.height));
  return ids;
}

fs::path existing(const fs::path& path) {
  if (!fs::is_regular_file(path)) throw InputError(path, "is missing");
  return path;
}

void add_depth(const fs::path& source, const ConfigNode& settings, bool is_metric, SequenceFrame& frame,
               Recording& recording) {
  frame.depth = fmt::format("depth/{:06}.png", frame.frame);
  RecordedImage image{existing(source), frame.depth, ImageKind::depth};
  if (!is_metric)
    image.make = [bf = settings.positive("Camera.bf", kBf),
                  units = settings.positive("DepthMapFactor", kDisparityUnits),
                  camera = recording.sequence.camera](const fs::path& path) {
      const cv::Mat disparity = read_image(path);
      require_image(path, disparity, camera, ImageKind::depth);
      return depth_of_disparity(disparity, bf, units, kDepthUnitsPerM);
    };
  recording.images.push_back(image);
}

void read_frames(const fs::path& folder, const ConfigNode& settings, bool is_metric, Recording& recording) {
  const bool has_depth = fs::is_directory(folder / "depth"), has_ids = fs::is_directory(folder / "semantic");
  for (const std::int64_t stamp_ns : read_times(folder / "times.txt")) {
    const auto index = recording.sequence.frames.size();
    SequenceFrame& frame = add_frame(recording.sequence, stamp_ns, fmt::format("rgb/{:06}.png", index));
    const std::string png = fmt::format("{:06}.png", index);
    recording.images.push_back({existing(folder / "image_0" / png), frame.rgb, ImageKind::color, make_color});
    if (has_depth) add_depth(folder / "depth" / png, settings, is_metric, frame, recording);
    if (!has_ids) continue;
    frame.masks = "masks/" + png;
    frame.masks_arrival_ns = stamp_ns;
    recording.images.push_back(
        {existing(folder / "semantic" / fmt::format("{:06}.txt", index)), frame.masks, ImageKind::masks,
         [camera = recording.sequence.camera](const fs::path& path) { return read_ids(path, camera); }});
  }
  if (recording.sequence.frames.empty()) throw InputError(folder / "times.txt", "has no time");
  recording.sequence.rate_hz = nominal_rate_hz(stamps_of(recording.sequence.frames), kCameraRateHz);
}

void append(const fs::path& path, int line, Trajectory& trajectory, std::int64_t stamp_ns, const Pose& pose) {
  require_later(path, line, trajectory, stamp_ns);
  trajectory.push_back({stamp_ns, pose});
}

// Lines of a frame's number and as many fields in all, those behind the number as numbers.
template <typename Visit>
void for_each_pose(const fs::path& path, std::size_t count, const std::vector<SequenceFrame>& frames,
                   const Visit& visit) {
  for_each_line(path, [&](int line, const Fields& fields) {
    if (fields.size() != count)
      throw InputError(path, line, fmt::format("expected {} fields, found {}", count, fields.size()));
    const auto frame = read_count(path, line, fields[0], "frame", std::ssize(frames));
    visit(line, frames[frame].stamp_ns, fields);
  });
}

Trajectory read_camera_poses(const fs::path& path, const std::vector<SequenceFrame>& frames) {
  Trajectory trajectory;
  for_each_pose(path, kCameraFields, frames, [&](int line, std::int64_t stamp_ns, const Fields& fields) {
    append(path, line, trajectory, stamp_ns, read_pose_rows(path, line, read_numbers(path, line, fields, 1)));
  });
  return trajectory;
}

std::map<std::string, Trajectory> read_object_poses(const fs::path& path,
                                                    const std::vector<SequenceFrame>& frames) {
  std::map<std::string, Trajectory> bodies;
  for_each_pose(path, kObjectFields, frames, [&](int line, std::int64_t stamp_ns, const Fields& fields) {
    const auto id = read_count(path, line, fields[1], "id", kIds);
    const auto v = read_numbers(path, line, fields, 2);
    append(path, line, bodies[fmt::format("object {}", id)], stamp_ns,
           {exp_so3({v[3], v[4], v[5]}), {v[0], v[1], v[2]}});
  });
  return bodies;
}

}  // namespace

Recording read_omd_processed(const fs::path& folder, const ImportOmdOptions& options) {
  Recording recording;
  recording.sequence = begin_sequence(recording_name(folder));
  const ConfigNode settings = load_settings(settings_file(folder, options.calibration));
  recording.sequence.camera = read_settings_camera(settings);
  recording.sequence.depth_units_per_m =
      options.metric_depth ? settings.positive("DepthMapFactor") : kDepthUnitsPerM;
  read_frames(folder, settings, options.metric_depth, recording);
  if (!fs::exists(folder / "pose_gt.txt")) return recording;
  const auto& frames = recording.sequence.frames;
  const fs::path objects = folder / "object_pose.txt";
  set_truth(
      camera_poses(folder / "pose_gt.txt", read_camera_poses(folder / "pose_gt.txt", frames), recording),
      fs::exists(objects) ? read_object_poses(objects, frames) : std::map<std::string, Trajectory>(),
      [](const auto& object) { return fmt::format("object {}", object.id); }, options.objects, recording);
  return recording;
}

}  // namespace uniquadric
