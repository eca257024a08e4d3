#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/ply.h"
#include "core/sequence/tracks.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {

/// One sighting of a point of a body, a row of ESTIMATE/features.csv.
struct SightedDepth {
  std::int64_t stamp_ns = 0;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< of the image without distortion
  std::optional<double> depth_m;                    ///< z of the camera frame; nothing: not recovered
};

/// How well the depth of features was recovered.
struct FeatureDepthError {
  std::uint64_t sightings = 0, off_body = 0;  ///< off: their line of sight does not meet the true surface
  double coverage = 0;                        ///< share of the others that have a depth
  std::optional<Statistics> error_m;          ///< |estimated - true depth| of those
  std::optional<double> quantile_90_m;
};

/// Rows of features.csv by the body's id; empty without the file. Throws InputError with file and line.
std::map<int, std::vector<SightedDepth>> read_features(const std::filesystem::path& estimate);

/// Against the true surface at its true pose, seen from the true camera: no estimated pose comes in. `camera`
/// is the lens, whose distortion is left out. Sightings without a true pose of both are passed over.
std::optional<FeatureDepthError> feature_depth_error(const std::vector<SightedDepth>& sightings,
                                                     const SurfaceFile& surface, const ObjectTrack& object,
                                                     const Trajectory& world_from_camera,
                                                     const Camera& camera, std::int64_t max_difference_ns);

}  // namespace uniquadric
