#include "tests/ego/room_recording.h"

#include <fmt/format.h>

#include <opencv2/core.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

constexpr std::int64_t kFrame_ns = 50'000'000;

cv::Mat grey_noise(const Camera& camera, int frame) {
  RandomStream random(3, "room_image", static_cast<std::uint64_t>(frame));
  cv::Mat image(camera.height, camera.width, CV_8UC3);
  for (int v = 0; v < image.rows; ++v)
    for (int u = 0; u < image.cols; ++u)
      image.at<cv::Vec3b>(v, u) = cv::Vec3b::all(static_cast<std::uint8_t>(random.below(256)));
  return image;
}

void add_images(const fs::path& folder, const RoomRecording& recording, Sequence& sequence) {
  Camera& camera = sequence.camera;
  camera.width = 80, camera.height = 60;
  camera.fx = camera.fy = 60;
  camera.cx = 39.5, camera.cy = 29.5;
  cv::Mat masks = cv::Mat::zeros(camera.height, camera.width, CV_16UC1);
  masks(cv::Rect(30, 25, 20, 15)) = 1;
  for (const char* name : {"rgb", "masks"}) fs::create_directories(folder / name);
  const auto frames = static_cast<int>(recording.scans / recording.room.rate_hz * 1e9 / kFrame_ns);
  for (int i = 1; i < frames; ++i) {
    SequenceFrame frame;
    frame.frame = i - 1;
    frame.stamp_ns = frame.masks_arrival_ns = recording.room.start_ns + i * kFrame_ns;
    frame.rgb = fmt::format("rgb/{}.png", i);
    frame.masks = fmt::format("masks/{}.png", i);
    write_png(folder / frame.rgb, grey_noise(camera, i));
    write_png(folder / frame.masks, masks);
    sequence.frames.push_back(frame);
  }
}

}  // namespace

Eigen::Quaterniond camera_from_forward() {
  return Eigen::Quaterniond(0.5, 0.5, -0.5, 0.5);
}

Sequence write_recording(const fs::path& folder, const RoomRecording& recording) {
  const LidarRoom& room = recording.room;
  Sequence sequence;
  sequence.folder = folder;
  sequence.name = "room";
  sequence.rate_hz = recording.has_images ? 1e9 / kFrame_ns : room.rate_hz;
  sequence.lidar = LidarCalibration{.pattern = "room",
                                    .rate_hz = room.rate_hz,
                                    .camera_from_lidar = {camera_from_forward(), {0.1, 0.2, -0.05}}};
  fs::remove_all(folder);
  fs::create_directories(folder / "lidar");
  for (int i = 0; i < recording.scans; ++i) {
    sequence.scans.push_back(
        {room.scan_start_ns(i) + recording.lidar_clock_ns, fmt::format("lidar/{}.pcd", i)});
    std::vector<LidarPoint> points = room.scan(i);
    if (recording.change) recording.change(i, points);
    write_lidar_points(folder / sequence.scans.back().file, points);
  }
  if (recording.has_imu) {
    sequence.imu = ImuCalibration{.camera_from_imu = sequence.lidar->camera_from_lidar};
    auto samples = room.imu(recording.scans / room.rate_hz);
    for (ImuSample& sample : samples) sample.stamp_ns += recording.imu_clock_ns;
    write_imu_csv(folder / "imu.csv", samples);
  }
  if (recording.has_images) add_images(folder, recording, sequence);
  write_sequence_index(folder, sequence);
  if (!recording.has_images) fs::remove(folder / "rgb.txt");
  return open_sequence(folder);
}

}  // namespace uniquadric
