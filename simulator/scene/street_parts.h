#pragma once

#include <Eigen/Core>
#include <vector>

#include "simulator/scene/mesh.h"
#include "simulator/scene/texture.h"

namespace uniquadric {

/// Parts of a street. They stand on z = 0.

/// Appends a sharp box about `centre`; each face shows the whole texture.
void add_box(Mesh& mesh, const Eigen::Vector3d& centre, const Eigen::Vector3d& size_m);

/// A house of `size_m` (width x, depth y, height z) whose front lies in the plane y = 0 and faces -y, x
/// symmetric; ledges and awning stand out of it by up to 1 m. Windows are set back in rows.
std::vector<Mesh> building(const Eigen::Vector3d& size_m, const Material& wall, const Material& trim,
                           const Material& glass);

/// What stands on a pavement, about the origin.
std::vector<Mesh> street_lamp(double height_m, const Material& metal);
std::vector<Mesh> tree(double height_m, const Material& bark, const Material& leaves);
std::vector<Mesh> kiosk(const Eigen::Vector3d& size_m, const Material& walls, const Material& roof);

}  // namespace uniquadric
