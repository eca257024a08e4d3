#pragma once

#include "estimator/objects/body_estimator.h"
#include "synthetic_perception.h"

namespace uniquadric {

inline const Eigen::Vector3d kAxes(0.3, 0.2, 0.15);  ///< [m]

/// The axes in the order of their lengths: their names are the estimator's choice.
Eigen::Vector3d by_size(Eigen::Vector3d axes);

/// world_from_camera at `from`, with `at` on its optical axis.
Pose looking_at(const Eigen::Vector3d& from, const Eigen::Vector3d& at);

/// world_from_body of one that turns about a slanted axis and wanders, at a time [s].
Pose tumbling(double t);

/// Three seconds of a camera that goes along an arc about (0, 0, 1).
SyntheticOptions three_seconds();

/// The largest over the frames asked for.
struct Errors {
  double translation_m = 0, rotation_rad = 0, axes_m = 0;
  int frames = 0;
};

/// Those of the first body of each frame against `body`, from a time on; the axes' names are the estimator's
/// choice.
Errors largest_errors(const SyntheticPerception& perception, const SyntheticBody& body,
                      const SyntheticOptions& options, double from_s, const BodyOptions& body_options = {});
/// The same of what perception makes of the body.
Errors largest_errors(const SyntheticBody& body, const SyntheticOptions& options, double from_s,
                      const BodyOptions& body_options = {});

}  // namespace uniquadric
