#include "core/geometry/box_symmetry.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>

namespace uniquadric {
namespace {

std::array<Eigen::Matrix3d, 24> make_box_rotations() {
  std::array<Eigen::Matrix3d, 24> rotations;
  std::size_t count = 0;
  std::array<int, 3> axis = {0, 1, 2};
  do {
    for (int signs = 0; signs < 8; ++signs) {
      Eigen::Matrix3d P = Eigen::Matrix3d::Zero();
      for (int column = 0; column < 3; ++column) P(axis[column], column) = (signs >> column) & 1 ? -1 : 1;
      if (P.determinant() > 0) rotations[count++] = P;
    }
  } while (std::next_permutation(axis.begin(), axis.end()));
  assert(count == rotations.size());
  return rotations;
}

}  // namespace

const std::array<Eigen::Matrix3d, 24>& box_rotations() {
  static const std::array<Eigen::Matrix3d, 24> rotations = make_box_rotations();
  return rotations;
}

Eigen::Matrix3d nearest_box_rotation(const Eigen::Matrix3d& R, const Eigen::Matrix3d& reference) {
  const Eigen::Matrix3d towards = reference.transpose() * R;
  const auto trace = [&](const Eigen::Matrix3d& P) { return (towards * P).trace(); };  // 1 + 2 cos(angle)
  return *std::max_element(box_rotations().begin(), box_rotations().end(),
                           [&](const auto& a, const auto& b) { return trace(a) < trace(b); });
}

Ellipsoid relabel_axes(const Ellipsoid& ellipsoid, const Eigen::Matrix3d& P) {
  if (P == Eigen::Matrix3d::Identity()) return ellipsoid;
  Ellipsoid result = ellipsoid;
  result.world_from_object.rotation =
      (ellipsoid.world_from_object.rotation * Eigen::Quaterniond(P)).normalized();
  result.semi_axes_m = P.cwiseAbs().transpose() * ellipsoid.semi_axes_m;
  return result;
}

}  // namespace uniquadric
