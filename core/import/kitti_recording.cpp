#include "core/import/kitti_recording.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/error.h"
#include "core/base/text.h"
#include "core/import/fields.h"
#include "core/sequence/sequence.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr int kMostFrames = 10'000'000;
constexpr int kWidth = 1242, kHeight = 375;  // KITTI's images, where there are none and no calibration

FilesByFrame numbered_files(const fs::path& folder, const std::set<std::string>& extensions) {
  FilesByFrame files;
  if (!fs::is_directory(folder)) return files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (!extensions.contains(entry.path().extension().string())) continue;
    const std::string stem = entry.path().stem().string();
    const auto frame = parse_integer(stem);
    if (!frame || *frame < 0 || *frame >= kMostFrames)
      throw InputError(entry.path(), "is named by no frame's number");
    if (!files.try_emplace(*frame, entry.path()).second)
      throw InputError(entry.path(), fmt::format("frame {} has another file", *frame));
  }
  return files;
}

std::string choose_drive(const fs::path& folder, const std::string& wanted) {
  std::set<std::string> drives;
  for (const char* kind : {"image_02", "velodyne"})
    if (fs::is_directory(folder / kind))
      for (const auto& entry : fs::directory_iterator(folder / kind))
        if (entry.is_directory()) drives.insert(entry.path().filename().string());
  if (drives.empty())
    throw InputError(folder, "holds no recording: neither image_02/0000/ nor velodyne/0000/");
  if (wanted.empty() && drives.size() == 1) return *drives.begin();
  if (!drives.contains(wanted))
    throw InputError(folder,
                     fmt::format("holds the recordings {}: choose one by --drive", fmt::join(drives, ", ")));
  return wanted;
}

// One value a frame, or the file is of another recording.
template <typename T>
std::vector<T> each_frame(const fs::path& path, std::vector<T> values, std::size_t frames) {
  if (values.size() != frames)
    throw InputError(path, fmt::format("has {} lines for {} frames", values.size(), frames));
  return values;
}

void read_stamps(KittiRecording& recording) {
  const auto end_of = [](const FilesByFrame& files) { return files.empty() ? 0 : files.rbegin()->first + 1; };
  const std::int64_t frames = std::max(end_of(recording.images), end_of(recording.scans));
  if (frames == 0)
    throw InputError(recording.folder, fmt::format("has no image and no scan of {}", recording.drive));
  if (fs::exists(recording.file("times"))) {
    recording.stamps_ns = read_times(recording.file("times"));
    if (std::ssize(recording.stamps_ns) < frames)
      throw InputError(recording.file("times"),
                       fmt::format("has {} lines for {} frames", recording.stamps_ns.size(), frames));
    return;
  }
  for (std::int64_t i = 0; i < frames; ++i)
    recording.stamps_ns.push_back(std::llround(static_cast<double>(i) * 1e9 / kKittiRateHz));
}

void read_calibration_of(KittiRecording& recording) {
  const bool by_oxts = !fs::exists(recording.file("poses")) && fs::exists(recording.file("oxts"));
  const bool is_needed = by_oxts || !recording.images.empty() || fs::exists(recording.file("label_02"));
  KittiCalibration& calibration = recording.calibration;
  Camera& camera = calibration.camera;
  if (is_needed || fs::exists(recording.file("calib"))) {
    calibration = read_kitti_calibration(recording.file("calib"), by_oxts);
    camera.width = static_cast<int>(std::lround(2 * camera.cx)) + 1;  // but for an image that says it
    camera.height = static_cast<int>(std::lround(2 * camera.cy)) + 1;
  } else {
    calibration.camera_from_velodyne = camera_from_velodyne_axes();
    camera.width = kWidth, camera.height = kHeight;
    camera.cx = (kWidth - 1) / 2.0, camera.cy = (kHeight - 1) / 2.0;
  }
  if (recording.images.empty()) return;
  const cv::Mat image = read_image(recording.images.begin()->second);
  camera.width = image.cols, camera.height = image.rows;
}

void read_camera_poses(KittiRecording& recording) {
  const std::size_t frames = recording.stamps_ns.size();
  const KittiCalibration& c = recording.calibration;
  if (const fs::path path = recording.file("poses"); fs::exists(path)) {
    for (const Pose& pose : each_frame(path, read_kitti_poses(path), frames))
      recording.world_from_camera.push_back(pose * c.camera_from_rectified.inverse());
  } else if (const fs::path oxts = recording.file("oxts"); fs::exists(oxts)) {
    const Pose imu_from_camera = (c.camera_from_velodyne * c.velodyne_from_imu).inverse();
    for (const Pose& pose : each_frame(oxts, read_kitti_oxts(oxts), frames))
      recording.world_from_camera.push_back(pose * imu_from_camera);
  }
  for (Pose& pose : recording.world_from_camera) pose.rotation.normalize();
}

}  // namespace

KittiRecording read_kitti_recording(const fs::path& folder, const std::string& drive) {
  KittiRecording recording;
  recording.folder = folder;
  recording.drive = choose_drive(folder, drive);
  recording.images = numbered_files(folder / "image_02" / recording.drive, {".png"});
  recording.scans = numbered_files(folder / "velodyne" / recording.drive, {".bin", ".pcd"});
  read_stamps(recording);
  read_calibration_of(recording);
  read_camera_poses(recording);
  if (fs::exists(recording.file("label_02")))
    recording.labels = read_kitti_labels(recording.file("label_02"), std::ssize(recording.stamps_ns));
  return recording;
}

}  // namespace uniquadric
