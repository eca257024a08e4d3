#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/pose.h"
#include "evaluation/trajectory/delta_pairs.h"
#include "evaluation/trajectory/pose_error.h"

namespace uniquadric {

/// Reference and estimate in pairs of one time, in order of time: what all trajectory errors start from.
struct PosePairs {
  std::vector<std::int64_t> stamps_ns;  ///< of the reference
  std::vector<Pose> reference, estimate;
  std::size_t size() const { return reference.size(); }
};

/// SPEC 6: with fewer pairs there are no error figures.
inline constexpr std::size_t kMinPairs = 3;

/// Absolute pose errors, one a pair.
std::vector<PoseError> absolute_errors(const PosePairs& poses);

/// Relative pose errors, one for each of `steps`.
std::vector<PoseError> relative_errors(const PosePairs& poses, const std::vector<IndexStep>& steps);

/// One part of errors, as `statistics` takes it.
std::vector<double> translations_m(const std::vector<PoseError>& errors);
std::vector<double> rotations_rad(const std::vector<PoseError>& errors);

/// Greatest deviation after the first poses have been made to coincide (OMD's protocol, without its
/// calibration).
struct Drift {
  double max_translation_m = 0;
  /// of the reference's path up to the frame of max_translation_m; nothing where nothing has moved yet
  std::optional<double> max_translation_percent_of_path;
  double max_angle_rad = 0;
  std::size_t translation_index = 0, angle_index = 0;  ///< pairs where the maxima are
};
/// Nothing without pairs.
std::optional<Drift> maximum_drift(const PosePairs& poses);

}  // namespace uniquadric
