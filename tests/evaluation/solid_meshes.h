#pragma once

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <vector>

#include "evaluation/iou/solid.h"

namespace uniquadric {

struct TestMesh {
  std::vector<Eigen::Vector3f> corners;
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

inline Solid solid_of(const TestMesh& mesh) {
  return {{}, std::make_shared<MeshSolid>(mesh.corners, mesh.triangles)};
}

/// Two triangles a side facing outwards, the two of the lid (+z) last; corners not shared between sides.
inline TestMesh box_mesh(const Eigen::Vector3f& middle, const Eigen::Vector3f& half) {
  TestMesh mesh;
  const auto add_side = [&](const Eigen::Vector3f& normal, const Eigen::Vector3f& u,
                            const Eigen::Vector3f& v) {
    const auto at = static_cast<std::uint32_t>(mesh.corners.size());
    for (const auto& [s, t] : {std::pair(-1.0F, -1.0F), {1.0F, -1.0F}, {1.0F, 1.0F}, {-1.0F, 1.0F}})
      mesh.corners.emplace_back(middle + half.cwiseProduct(normal + s * u + t * v));
    mesh.triangles.push_back({at, at + 1, at + 2});
    mesh.triangles.push_back({at, at + 2, at + 3});
  };
  const Eigen::Vector3f x = Eigen::Vector3f::UnitX(), y = Eigen::Vector3f::UnitY(),
                        z = Eigen::Vector3f::UnitZ();
  add_side(x, y, z), add_side(-x, z, y), add_side(y, z, x), add_side(-y, x, z), add_side(-z, y, x);
  add_side(z, x, y);
  return mesh;
}

inline TestMesh joined(TestMesh a, const TestMesh& b) {
  const auto at = static_cast<std::uint32_t>(a.corners.size());
  a.corners.insert(a.corners.end(), b.corners.begin(), b.corners.end());
  for (const auto& [i, j, k] : b.triangles) a.triangles.push_back({at + i, at + j, at + k});
  return a;
}

/// A ball of radius 1 of 2 * rings * (rings - 1) triangles facing outwards; poles are shared.
inline TestMesh ball_mesh(std::uint32_t rings) {
  TestMesh mesh;
  const std::uint32_t around = rings;
  for (std::uint32_t i = 0; i <= rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const double polar = std::numbers::pi * i / rings, angle = 2 * std::numbers::pi * j / around;
      const double ring = i == 0 || i == rings ? 0 : std::sin(polar);
      mesh.corners.emplace_back(
          Eigen::Vector3d(ring * std::cos(angle), ring * std::sin(angle), std::cos(polar)).cast<float>());
    }
  for (std::uint32_t i = 0; i < rings; ++i)
    for (std::uint32_t j = 0; j < around; ++j) {
      const std::uint32_t a = i * around + j, b = i * around + (j + 1) % around;
      if (i > 0) mesh.triangles.push_back({a, a + around, b});
      if (i + 1 < rings) mesh.triangles.push_back({b, a + around, b + around});
    }
  return mesh;
}

}  // namespace uniquadric
