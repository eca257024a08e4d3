#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace uniquadric {

/// How far points lie off the triangles of a body, by Embree's point query, the distance itself in double
/// precision; and where rays meet them.
class SurfaceDistance {
 public:
  /// Corners in the body's frame [m], finite; triangles of indices into them.
  SurfaceDistance(std::vector<Eigen::Vector3f> corners, std::vector<std::array<std::uint32_t, 3>> triangles);
  /// Distance [m] of a point in the body's frame to the nearest triangle; `most_m` where none is nearer. From
  /// beyond a thousand sizes of the surface that to its box, which differs by 0.1 % at most.
  double at(const Eigen::Vector3d& point, double most_m = std::numeric_limits<double>::infinity()) const;
  /// Where a ray meets a triangle first, in lengths of its direction; nothing: it passes by. In single
  /// precision.
  std::optional<double> along(const Eigen::Vector3d& from, const Eigen::Vector3d& direction) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace uniquadric
