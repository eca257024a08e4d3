#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace uniquadric {

/// What the triangles of a mesh say of its inside, after corners at the same place were made one.
enum class MeshKind {
  closed,             ///< every edge is passed as often one way as the other
  closed_unoriented,  ///< every edge belongs to an even number of triangles, but they face either way
  open,               ///< there are holes
};
const char* to_string(MeshKind kind);

/// The body that a triangle mesh encloses. A ray from a point counts the triangles that it crosses:
/// - closed: the crossings outwards less those inwards, inside where they differ. Parts that overlap are a
///   union; triangles may face outwards or inwards.
/// - closed_unoriented: an odd number is inside.
/// - open: the generalised winding number (Jacobson, Kavan and Sorkine-Hornung, 2013) as a mean over 32
///   directions, inside where it is beyond 0.5 in size.
/// Rays are traced in single precision about the middle of the mesh.
class MeshSolid {
 public:
  /// Corners in the body's frame [m], finite; triangles of indices into them. Throws std::runtime_error when
  /// Embree runs out of memory.
  MeshSolid(const std::vector<Eigen::Vector3f>& corners,
            const std::vector<std::array<std::uint32_t, 3>>& triangles);
  MeshKind kind() const;
  /// Around all triangles [m]; empty without triangles.
  const Eigen::AlignedBox3d& box() const;
  /// Of a closed mesh whose parts lie apart, by the divergence theorem [m^3]; nothing of others.
  std::optional<double> known_volume() const;
  /// Of each point [m] 1 where it is inside, else 0; on all processors.
  std::vector<char> contains(std::span<const Eigen::Vector3d> points) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

}  // namespace uniquadric
