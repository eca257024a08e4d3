#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <functional>
#include <vector>

#include "core/geometry/pose.h"
#include "simulator/scene/mesh.h"

namespace uniquadric {

/// A mesh vertex before rounding to single precision: [m] in the body's frame, unit normal, texture
/// coordinate.
struct Vertex {
  Eigen::Vector3d position, normal;
  Eigen::Vector2d uv;
};

/// Corners (0,0) and (1,1) of the part of a texture that a surface shows.
using TextureWindow = Eigen::AlignedBox2d;
inline const TextureWindow kWholeTexture{Eigen::Vector2d::Zero(), Eigen::Vector2d::Ones()};

/// Appends a surface of rows x columns cells whose vertices are `vertex(row, column)`, rows and columns
/// inclusive. Outside is the side that (direction of columns) x (direction of rows) points to; cells that
/// `skip` names are left open.
void add_grid(Mesh& mesh, int rows, int columns, const std::function<Vertex(int, int)>& vertex,
              const std::function<bool(int, int)>& skip = {});

/// Appends the flat quad a, b, c, d, counter-clockwise seen from outside; a carries the window's lower left
/// corner.
void add_quad(Mesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
              const Eigen::Vector3d& d, const TextureWindow& window = kWholeTexture);

/// Replaces the normals by the area-weighted means of the faces that share a vertex position.
void smooth_normals(Mesh& mesh);

/// A normal of a file at length 1. A vertex without an area around it has none: any unit vector, here (0, 0,
/// 1), keeps the shading finite.
Eigen::Vector3f unit_normal(const Eigen::Vector3f& normal);

/// Moves meshes rigidly.
void transform(std::vector<Mesh>& meshes, const Pose& to_from_mesh);

/// The tight axis-aligned box of all vertices [m]; empty when there are none.
Eigen::AlignedBox3d tight_box(const std::vector<Mesh>& meshes);

/// Centres the meshes' tight box at the origin and stretches each axis so that its extents are `size_m`, to
/// single precision. An axis without extent is only centred.
void fit_to_box(std::vector<Mesh>& meshes, const Eigen::Vector3d& size_m);

/// Appends the triangles of `more`, whose look is left behind.
void merge(Mesh& mesh, const Mesh& more);

/// Appends all of `more`.
void append(std::vector<Mesh>& meshes, std::vector<Mesh> more);

}  // namespace uniquadric
