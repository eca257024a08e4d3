#pragma once

#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "estimator/observation/perception.h"

namespace uniquadric {

/// Tells outlines that a rigid body cannot have: two bodies under one mask, or half a body. Its width across
/// a direction changes with its distance and as it turns, by no more than its diameter a radian.
class OutlineWatch {
 public:
  /// Whether an outline seen at `camera_from_body` may be the body's, given the last one that was; true where
  /// that one is too old to say, or too much of either is cut. `center`: the body's, in its own frame [m].
  bool may_be(const Camera& camera, const Silhouette& outline, std::int64_t stamp_ns,
              const Pose& camera_from_body, const Eigen::Vector3d& center) const;

  /// Takes it for the body's.
  void trust(const Camera& camera, const Silhouette& outline, std::int64_t stamp_ns,
             const Pose& camera_from_body, const Eigen::Vector3d& center);

 private:
  struct Outline {
    std::int64_t stamp_ns;
    Eigen::Quaterniond camera_from_body;
    std::vector<std::optional<double>> widths_m;  // across each direction; nothing: cut
  };

  std::optional<Outline> last_;
};

}  // namespace uniquadric
