#include "simulator/scene/contact.h"

#include <algorithm>
#include <array>
#include <set>

#include "core/geometry/sphere_direction.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr int kDirections = 500;  // ours: a ball's points are then within half a percent of its radius
constexpr int kRounds = 100;
constexpr double kSettled_mps = 1e-9;  // changes below it end the rounds

// Evenly over the sphere, and the axes, so that the points span the tight box.
std::vector<Vector3d> directions() {
  std::vector<Vector3d> list;
  for (int k = 0; k < 3; ++k)
    for (const double sign : {-1, 1}) list.push_back(sign * Vector3d::Unit(k));
  for (int k = 0; k < kDirections; ++k) list.push_back(sphere_direction(k, kDirections));
  return list;
}

double inverse_mass(const Eigen::Matrix3d& inverse_inertia, const Vector3d& arm, const Vector3d& direction) {
  const Vector3d lever = arm.cross(direction);
  return 1 + lever.dot(inverse_inertia * lever);
}

// Along the axes, of each contact: they stay the same over the rounds.
std::vector<Vector3d> inverse_masses(const Eigen::Matrix3d& inverse_inertia,
                                     const std::vector<Contact>& contacts) {
  std::vector<Vector3d> masses(contacts.size());
  for (std::size_t i = 0; i < contacts.size(); ++i)
    for (int k = 0; k < 3; ++k)
      masses[i][k] = inverse_mass(inverse_inertia, contacts[i].arm_m, Vector3d::Unit(k));
  return masses;
}

/// The impulse that the contact wants in all: upwards only, friction within Coulomb's cone.
Vector3d wanted_impulse(const Twist& twist, const Vector3d& inverse_masses, double friction,
                        const Contact& contact) {
  const Vector3d lack = Vector3d(0, 0, contact.least_mps) - twist.at(contact.arm_m);
  Vector3d impulse = contact.impulse_mps;
  impulse += lack.cwiseQuotient(inverse_masses);
  impulse.z() = std::max(impulse.z(), 0.0);
  const double sideways = impulse.head<2>().norm(), most = friction * impulse.z();
  if (sideways > most) impulse.head<2>() *= most / sideways;
  return impulse;
}

}  // namespace

std::vector<Vector3d> contact_points(std::span<const Mesh> meshes) {
  std::set<std::array<float, 3>> points;
  for (const Vector3d& direction : directions()) {
    const Eigen::Vector3f* farthest = nullptr;
    for (const Mesh& mesh : meshes)
      for (const Eigen::Vector3f& p : mesh.positions)
        if (!farthest || direction.dot((p - *farthest).cast<double>()) > 0) farthest = &p;
    if (farthest) points.insert({farthest->x(), farthest->y(), farthest->z()});
  }
  std::vector<Vector3d> result;
  for (const auto& [x, y, z] : points) result.emplace_back(x, y, z);
  return result;
}

void stop_at_contacts(Twist twist, const Eigen::Matrix3d& inverse_inertia, double friction,
                      std::vector<Contact>& contacts) {
  const std::vector<Vector3d> masses = inverse_masses(inverse_inertia, contacts);
  for (int round = 0; round < kRounds; ++round) {
    double change_mps = 0;
    for (std::size_t i = 0; i < contacts.size(); ++i) {
      Contact& contact = contacts[i];
      const Vector3d impulse = wanted_impulse(twist, masses[i], friction, contact);
      const Vector3d more = impulse - contact.impulse_mps;
      twist.velocity_mps += more;
      twist.angular_velocity_radps += inverse_inertia * contact.arm_m.cross(more);
      contact.impulse_mps = impulse;
      change_mps = std::max(change_mps, more.lpNorm<Eigen::Infinity>());
    }
    if (change_mps < kSettled_mps) break;
  }
}

}  // namespace uniquadric
