#pragma once

#include "core/sequence/ply.h"
#include "simulator/scene/mesh.h"

namespace uniquadric {

/// The triangles of a surface with their texture coordinates, without its points that none has, without its
/// look. Normals are the surface's, else smooth_normals(); (0, 0, 1) where neither says one.
Mesh mesh_of(const SurfaceFile& surface);

}  // namespace uniquadric
