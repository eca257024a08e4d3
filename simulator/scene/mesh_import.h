#pragma once

#include <filesystem>
#include <vector>

#include "simulator/scene/mesh.h"

namespace uniquadric {

struct ImportedMesh {
  std::vector<Mesh> meshes;                  ///< one a material, in the file's own frame and unit
  std::vector<std::filesystem::path> files;  ///< every file that was read, the mesh's own first
};

/// Reads a PLY (read_surface_ply()), or a mesh that assimp knows (OBJ, GLB and more), with its diffuse
/// textures, from files beside it or embedded. Vertex colours are not read. Throws InputError naming the file
/// for one that is missing or malformed, has no faces, vertices that are not finite, or a texture that cannot
/// be decoded.
ImportedMesh import_mesh(const std::filesystem::path& path);

}  // namespace uniquadric
