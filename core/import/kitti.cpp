#include "core/import/kitti.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdint>
#include <limits>
#include <map>
#include <memory>
#include <utility>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/read_file.h"
#include "core/base/text.h"
#include "core/import/kitti_recording.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

// Files with the same bytes in consecutive frames: a scan that is slower than the images.
std::vector<std::int64_t> frames_of_scans(const FilesByFrame& scans) {
  std::vector<std::int64_t> frames;
  std::string before;
  std::int64_t first = 0, last = -2;
  const auto close = [&] {
    if (last >= 0) frames.push_back((first + last) / 2);
  };
  for (const auto& [frame, file] : scans) {
    std::string bytes = read_file(file, kPointFile);
    if (frame != last + 1 || bytes.empty() || bytes != before) {
      close();
      first = frame;
    }
    last = frame;
    before = std::move(bytes);
  }
  close();
  return frames;
}

Trajectory camera_trajectory(const KittiRecording& recording) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < recording.world_from_camera.size(); ++i)
    trajectory.push_back({recording.stamps_ns[i], recording.world_from_camera[i]});
  return trajectory;
}

Sequence describe(const KittiRecording& recording) {
  Sequence sequence = begin_sequence(recording_name(recording.folder) + "_" + recording.drive);
  sequence.camera = recording.calibration.camera;
  sequence.rate_hz = nominal_rate_hz(recording.stamps_ns, kKittiRateHz);
  for (const auto& [number, image] : recording.images)
    add_frame(sequence, recording.stamps_ns[number], fmt::format("rgb/{:06}.png", number));
  if (!recording.world_from_camera.empty()) sequence.given_camera = camera_trajectory(recording);
  if (recording.scans.empty()) return sequence;
  const std::vector<std::int64_t> frames = frames_of_scans(recording.scans);
  std::vector<std::int64_t> stamps_ns;
  for (const std::int64_t frame : frames) stamps_ns.push_back(recording.stamps_ns[frame]);
  LidarCalibration& lidar = sequence.lidar.emplace();
  lidar.pattern = "recorded";
  lidar.rate_hz = nominal_rate_hz(stamps_ns, kKittiRateHz);
  lidar.camera_from_lidar = recording.calibration.camera_from_velodyne;
  const std::int64_t period_ns = std::llround(1e9 / lidar.rate_hz);
  for (std::size_t i = 0; i < frames.size(); ++i)
    sequence.scans.push_back({stamps_ns[i] - period_ns, fmt::format("lidar/{:06}.pcd", frames[i])});
  return sequence;
}

std::string shape_of(const std::string& type) {
  return type == "Car" ? "car" : type == "Tram" ? "carriage" : "box";
}

Eigen::Vector3d median_size(const std::vector<const KittiLabel*>& labels) {
  Eigen::Vector3d median;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> sizes;
    for (const KittiLabel* label : labels) sizes.push_back(label->semi_axes_m[axis]);
    median[axis] = upper_median(std::move(sizes));
  }
  return median;
}

// ours: annotated boxes of one body differ by less; a slip of the decimal point makes more
constexpr double kMostOfMedianSize = 2;

// What a track's labels say otherwise than its object has it, a line each.
void add_contradictions(const fs::path& file, const std::vector<const KittiLabel*>& labels,
                        const ObjectDescription& object, std::vector<std::string>& lines) {
  const KittiLabel& first = *labels.front();
  const auto other = std::find_if(labels.begin(), labels.end(),
                                  [&](const KittiLabel* label) { return label->type != first.type; });
  if (other != labels.end())
    lines.push_back(fmt::format("{}: track {} is a {}, in frame {} a {}: taken as the former", file.string(),
                                first.id, first.type, (*other)->frame, (*other)->type));
  const auto differs = [&](const KittiLabel* label) {
    const Eigen::Array3d ratio = label->semi_axes_m.array() / object.semi_axes_m.array();
    return ratio.maxCoeff() > kMostOfMedianSize || ratio.minCoeff() < 1 / kMostOfMedianSize;
  };
  const auto odd = std::find_if(labels.begin(), labels.end(), differs);
  if (odd != labels.end())
    lines.push_back(
        fmt::format("{}: the box of track {} in {} of {} frames, {} the first, is off its median size "
                    "by more than a factor {}: taken is the median",
                    file.string(), first.id, std::count_if(labels.begin(), labels.end(), differs),
                    labels.size(), (*odd)->frame, kMostOfMedianSize));
}

RecordedTruth describe_truth(const KittiRecording& recording, std::vector<std::string>& left_out) {
  RecordedTruth truth;
  const bool in_sensor_frame = recording.world_from_camera.empty();
  const int free_id = first_free_id(recording.labels);
  std::map<int, std::vector<const KittiLabel*>> by_id;
  for (const KittiLabel& label : recording.labels) by_id[object_id(label, free_id)].push_back(&label);
  for (auto& [id, labels] : by_id) {
    std::sort(labels.begin(), labels.end(), [](const auto* a, const auto* b) { return a->frame < b->frame; });
    for (const KittiLabel* label : labels) {
      const Pose camera = in_sensor_frame ? Pose{} : recording.world_from_camera[label->frame];
      Pose pose = camera * recording.calibration.camera_from_rectified * label->rectified_from_object;
      pose.rotation.normalize();
      truth.objects_at[id].push_back({recording.stamps_ns[label->frame], pose});
    }
    std::string name = fmt::format("{}_{}", labels.front()->type, id);
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
    truth.objects.push_back({id, name, median_size(labels), shape_of(labels.front()->type), ""});
    if (labels.front()->id != id)
      left_out.push_back(fmt::format("{}: track {} is object {} here, where ids begin at 1",
                                     recording.file("label_02").string(), labels.front()->id, id));
    add_contradictions(recording.file("label_02"), labels, truth.objects.back(), left_out);
  }
  truth.camera = camera_trajectory(recording);
  if (in_sensor_frame)
    for (const std::int64_t stamp_ns : recording.stamps_ns) truth.camera.push_back({stamp_ns, {}});
  truth.notes = {true, in_sensor_frame};  // labels are of some classes, and of what is near enough
  return truth;
}

// Frames between the first and the last file that have none: lost on the way, where scans are not slower.
void add_holes(const FilesByFrame& files, const char* what, Recording& recording) {
  if (files.empty()) return;
  const std::int64_t first = files.begin()->first, last = files.rbegin()->first;
  const std::int64_t holes = last - first + 1 - std::ssize(files);
  if (holes == 0) return;
  std::int64_t hole = first;
  while (files.contains(hole)) ++hole;
  recording.left_out.push_back(fmt::format("{}: {} of the frames {} to {} have no {}, the first {:06}",
                                           files.begin()->second.parent_path().string(), holes, first, last,
                                           what, hole));
}

// Reads scans by their frames, and says what their files have that is not taken: each field by the first
// file with it.
void add_scans(const KittiRecording& kitti, double rate_hz, Recording& recording) {
  const double period_s = 1 / rate_hz;
  if (1e9 * period_s > std::numeric_limits<std::uint32_t>::max())
    throw InputError(kitti.scans.begin()->second.parent_path(),
                     fmt::format("a scan comes every {:.4g} s, but a point's time in its scan goes to 4.29 s "
                                 "at most",
                                 period_s));
  const auto left_out = std::make_shared<std::map<std::string, fs::path>>();
  recording.read_scan = [scans = kitti.scans,
                         period_ns = static_cast<std::uint32_t>(std::llround(1e9 / rate_hz)),
                         left_out](const SequenceScan& scan) {
    const fs::path& path = scans.at(*parse_integer(scan.file.stem().string()));
    KittiScan read = read_kitti_scan(path, period_ns);
    for (const std::string& field : read.left_out) left_out->try_emplace(field, path);
    return std::move(read.points);
  };
  recording.left_out_of_scans = [left_out] {
    std::vector<std::string> lines;
    for (const auto& [field, path] : *left_out)
      lines.push_back(fmt::format("{}: field {} is not taken", path.string(), field));
    return lines;
  };
}

Recording as_recording(const KittiRecording& kitti) {
  Recording recording;
  recording.sequence = describe(kitti);
  for (const SequenceFrame& frame : recording.sequence.frames)
    recording.images.push_back(
        {std::next(kitti.images.begin(), frame.frame)->second, frame.rgb, ImageKind::color});
  if (const auto& lidar = recording.sequence.lidar) add_scans(kitti, lidar->rate_hz, recording);
  add_holes(kitti.images, "image", recording);
  add_holes(kitti.scans, "scan", recording);
  if (!kitti.world_from_camera.empty() || !kitti.labels.empty())
    recording.truth = describe_truth(kitti, recording.left_out);
  if (kitti.world_from_camera.empty() && !kitti.labels.empty())
    recording.left_out.push_back(fmt::format(
        "{}: neither poses nor oxts place its boxes in the world: they are taken in the camera's frame",
        kitti.file("label_02").string()));
  return recording;
}

}  // namespace

void import_kitti_tracking(const fs::path& folder, const ImportKittiOptions& options, const fs::path& out) {
  if (!fs::is_directory(folder)) throw InputError(folder, "is not a folder");
  write_recording(as_recording(read_kitti_recording(folder, options.drive)), options, out);
}

}  // namespace uniquadric
