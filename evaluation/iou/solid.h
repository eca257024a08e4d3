#pragma once

#include <Eigen/Geometry>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"
#include "evaluation/iou/mesh_solid.h"

namespace uniquadric {

/// A body in its own frame: what a mesh encloses, or without one a superellipsoid. Exponents of 1 are flat or
/// upright sides: all three 1 is a box, all three 2 an ellipsoid.
struct Solid {
  Superellipsoid body{};
  std::shared_ptr<const MeshSolid> mesh{};
};

/// The tight box of a superellipsoid, the box of a mesh's corners [m].
Eigen::AlignedBox3d bounding_box(const Solid& solid);

/// The volume in closed form [m^3]; nothing of a mesh that has none (MeshSolid::known_volume).
std::optional<double> known_volume(const Solid& solid);

/// Whether points are inside a superellipsoid. pow() is called only between two bodies around its surface
/// whose powers are 2, 4, 8, ..., which squaring gives.
class InsideTest {
 public:
  /// Points are in a frame in which the body has the pose points_from_body.
  explicit InsideTest(const Superellipsoid& body, const Pose& points_from_body = {});
  bool contains(const Eigen::Vector3d& point) const;

 private:
  Eigen::Matrix3d unit_from_points_;
  Eigen::Vector3d middle_;                      // in the points' frame
  double outline_ = 2, upper_ = 2, lower_ = 2;  // powers of the norms, infinite for flat sides
  int inner_ = 1;                               // squarings: 2^inner_ is at most each power
  std::optional<int> outer_;  // 2^outer_ is at least each power; nothing where they are too large
};

/// Of each point [m] in the solid's frame 1 where it is inside, else 0.
std::vector<char> contains(const Solid& solid, std::span<const Eigen::Vector3d> points);

}  // namespace uniquadric
