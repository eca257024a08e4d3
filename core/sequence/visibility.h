#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <opencv2/core/mat.hpp>
#include <utility>

namespace uniquadric {

/// A row of truth/instances/visibility.csv: how much of an object a frame shows.
struct ObjectVisibility {
  std::int64_t visible_px = 0;
  std::int64_t silhouette_px = 0;  ///< pixels of the image it would cover if nothing stood before it
  double visible_fraction = 0;     ///< of the silhouette; 0 where there is none
  bool touches_border = false;
};

/// By frame and object id.
using VisibilityTable = std::map<std::pair<std::int64_t, int>, ObjectVisibility>;

/// Reads visibility.csv. Throws InputError with file and line.
VisibilityTable read_visibility(const std::filesystem::path& path);

/// How many pixels each object has in a mask image (CV_16UC1, 0 background, which is not counted).
std::map<int, int> count_ids(const cv::Mat& masks);

}  // namespace uniquadric
