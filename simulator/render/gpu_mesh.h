#pragma once

#include <Eigen/Geometry>
#include <vector>

#include "simulator/render/gl_functions.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// A mesh in the memory of an OpenGL context; it lives as long as the context.
struct GpuMesh {
  unsigned vertex_array = 0, texture = 0;
  int index_count = 0;
  Eigen::Vector3f color = Eigen::Vector3f::Ones();  ///< (red, green, blue)
  float shine = 0, depth_return = 1;
  Eigen::AlignedBox3f box;  ///< that holds it
};

struct GpuBody {
  unsigned id = 0;
  std::vector<GpuMesh> meshes;
  Eigen::AlignedBox3f box;  ///< that holds the meshes, in the object frame
};

/// Copies a mesh and its texture, with mipmaps. Asserts that normals and uvs match the positions in number.
GpuMesh upload_mesh(const GlFunctions& gl, const Mesh& mesh);
/// With short edges (with_short_edges) where there are cameras.
GpuBody upload_body(const GlFunctions& gl, const Body& body, const std::vector<Eigen::Vector3f>& cameras_m);

}  // namespace uniquadric
