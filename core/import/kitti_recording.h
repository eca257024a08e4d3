#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/import/kitti_files.h"

namespace uniquadric {

inline constexpr double kKittiRateHz = 10;  ///< of its images and scans

using FilesByFrame = std::map<std::int64_t, std::filesystem::path>;

/// What a recording in the benchmark's layout says, but the contents of its images and scans.
struct KittiRecording {
  std::filesystem::path folder;
  std::string drive;
  FilesByFrame images, scans;
  std::vector<std::int64_t> stamps_ns;  // of each frame
  KittiCalibration calibration;
  std::vector<Pose> world_from_camera;  // of each frame; none where nothing tells
  std::vector<KittiLabel> labels;

  std::filesystem::path file(const char* kind) const { return folder / kind / (drive + ".txt"); }
};

/// Reads `drive` of a folder, the only one where it is empty. Throws InputError.
KittiRecording read_kitti_recording(const std::filesystem::path& folder, const std::string& drive);

}  // namespace uniquadric
