#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "simulator/scene/mesh.h"

namespace uniquadric {

/// The vertices of a body that can touch a plane: those farthest along several hundred directions [m].
std::vector<Eigen::Vector3d> contact_points(std::span<const Mesh> meshes);

/// Velocities of a rigid body of mass 1, in the world.
struct Twist {
  Eigen::Vector3d velocity_mps = Eigen::Vector3d::Zero(), angular_velocity_radps = Eigen::Vector3d::Zero();
  Eigen::Vector3d at(const Eigen::Vector3d& arm_m) const {
    return velocity_mps + angular_velocity_radps.cross(arm_m);
  }
};

/// A point of the body close to the horizontal plane below it.
struct Contact {
  Eigen::Vector3d arm_m;                                  ///< from the body's centre, in the world
  double gap_m = 0;                                       ///< above the plane
  double least_mps = 0;                                   ///< the vertical velocity that keeps it above
  Eigen::Vector3d impulse_mps = Eigen::Vector3d::Zero();  ///< that it received, for mass 1
};

/// Gives the contacts the impulses that stop what sinks in, with Coulomb friction (sequential impulses:
/// Catto, "Iterative dynamics with temporal coherence", GDC 2005).
void stop_at_contacts(Twist twist, const Eigen::Matrix3d& inverse_inertia, double friction,
                      std::vector<Contact>& contacts);

}  // namespace uniquadric
