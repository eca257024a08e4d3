#pragma once

#include <vector>

#include "simulator/render/renderer.h"
#include "simulator/scene/scene.h"

namespace uniquadric {

/// A closed sphere of `rings` x 2 `rings` cells, made here and not by the simulator.
Mesh sphere_mesh(double radius_m, int rings);
/// A closed box with a chequered texture.
Mesh box_mesh(const Eigen::Vector3d& semi_axes_m);

Motion fixed(const Pose& world_from_body);
Body make_body(int id, const Mesh& mesh, const Eigen::Vector3d& semi_axes_m, const Motion& motion);

/// A camera at the origin that looks along +z at two boxes (ids 7 and 300), the second moving across behind
/// the first, before a wall. Small images, every noise on.
Scene two_boxes();

/// A white square of 40 px before black; unshifted, its edges run between pixels.
Scene white_square();
/// That square, moved by so many pixels.
ScenePoses shifted(double x_px, double y_px);

}  // namespace uniquadric
