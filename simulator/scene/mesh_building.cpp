#include "simulator/scene/mesh_building.h"

#include <array>
#include <cmath>
#include <iterator>
#include <map>

namespace uniquadric {
namespace {

void push(Mesh& mesh, const Vertex& v) {
  mesh.positions.push_back(v.position.cast<float>());
  mesh.normals.push_back(v.normal.cast<float>());
  mesh.uvs.push_back(v.uv.cast<float>());
}

std::uint32_t size32(const Mesh& mesh) {
  return static_cast<std::uint32_t>(mesh.positions.size());
}

}  // namespace

void add_grid(Mesh& mesh, int rows, int columns, const std::function<Vertex(int, int)>& vertex,
              const std::function<bool(int, int)>& skip) {
  const std::uint32_t first = size32(mesh);
  for (int i = 0; i <= rows; ++i)
    for (int j = 0; j <= columns; ++j) push(mesh, vertex(i, j));
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      if (skip && skip(i, j)) continue;
      const auto a = first + static_cast<std::uint32_t>(i * (columns + 1) + j);
      const auto d = a + static_cast<std::uint32_t>(columns + 1);
      mesh.triangles.push_back({a, a + 1, d + 1});
      mesh.triangles.push_back({a, d + 1, d});
    }
}

void add_quad(Mesh& mesh, const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c,
              const Eigen::Vector3d& d, const TextureWindow& window) {
  const Eigen::Vector3d normal = (b - a).cross(d - a).normalized();
  const std::uint32_t first = size32(mesh);
  const Eigen::Vector2d low = window.min(), high = window.max();
  push(mesh, {a, normal, {low.x(), high.y()}});
  push(mesh, {b, normal, {high.x(), high.y()}});
  push(mesh, {c, normal, {high.x(), low.y()}});
  push(mesh, {d, normal, {low.x(), low.y()}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  mesh.triangles.push_back({first, first + 2, first + 3});
}

void smooth_normals(Mesh& mesh) {
  std::map<std::array<float, 3>, Eigen::Vector3d> sums;
  const auto key = [&](std::uint32_t i) {
    const Eigen::Vector3f& p = mesh.positions[i];
    return std::array<float, 3>{p.x(), p.y(), p.z()};
  };
  for (const auto& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.positions[t[0]].cast<double>(), b = mesh.positions[t[1]].cast<double>(),
                          c = mesh.positions[t[2]].cast<double>();
    const Eigen::Vector3d area = (b - a).cross(c - a);
    for (const std::uint32_t i : t) {
      auto [sum, fresh] = sums.try_emplace(key(i), Eigen::Vector3d::Zero());
      sum->second += area;
    }
  }
  for (std::uint32_t i = 0; i < size32(mesh); ++i)
    if (const auto sum = sums.find(key(i)); sum != sums.end())
      mesh.normals[i] = sum->second.normalized().cast<float>();
}

Eigen::Vector3f unit_normal(const Eigen::Vector3f& normal) {
  const float norm = normal.norm();
  return std::isfinite(norm) && norm > 0 ? normal.normalized() : Eigen::Vector3f::UnitZ();
}

void transform(std::vector<Mesh>& meshes, const Pose& to_from_mesh) {
  for (Mesh& mesh : meshes)
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      mesh.positions[i] = (to_from_mesh * mesh.positions[i].cast<double>()).cast<float>();
      mesh.normals[i] = (to_from_mesh.rotation * mesh.normals[i].cast<double>()).cast<float>();
    }
}

Eigen::AlignedBox3d tight_box(const std::vector<Mesh>& meshes) {
  Eigen::AlignedBox3d box;
  for (const Mesh& mesh : meshes)
    for (const Eigen::Vector3f& p : mesh.positions) box.extend(p.cast<double>());
  return box;
}

void fit_to_box(std::vector<Mesh>& meshes, const Eigen::Vector3d& size_m) {
  const Eigen::AlignedBox3d box = tight_box(meshes);
  const Eigen::Vector3d centre = box.center(), extent = box.sizes();
  Eigen::Vector3d stretch = Eigen::Vector3d::Ones();
  for (int k = 0; k < 3; ++k)
    if (extent[k] > 0) stretch[k] = size_m[k] / extent[k];
  for (Mesh& mesh : meshes)
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const Eigen::Vector3d p = mesh.positions[i].cast<double>() - centre;
      const Eigen::Vector3d n = mesh.normals[i].cast<double>();
      mesh.positions[i] = p.cwiseProduct(stretch).cast<float>();
      mesh.normals[i] = n.cwiseQuotient(stretch).normalized().cast<float>();
    }
}

void merge(Mesh& mesh, const Mesh& more) {
  const std::uint32_t first = size32(mesh);
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
  mesh.normals.insert(mesh.normals.end(), more.normals.begin(), more.normals.end());
  mesh.uvs.insert(mesh.uvs.end(), more.uvs.begin(), more.uvs.end());
  for (const auto& t : more.triangles) mesh.triangles.push_back({first + t[0], first + t[1], first + t[2]});
}

void append(std::vector<Mesh>& meshes, std::vector<Mesh> more) {
  std::move(more.begin(), more.end(), std::back_inserter(meshes));
}

}  // namespace uniquadric
