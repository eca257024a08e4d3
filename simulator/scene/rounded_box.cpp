#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

#include "simulator/scene/mesh_building.h"
#include "simulator/scene/shapes.h"

namespace uniquadric {
namespace {

/// Where the surface's grid cuts one axis: points on the enclosing sharp box and their place on the texture.
struct AxisLines {
  std::vector<double> at_m, uv;
  int recess = -1;  ///< first line of the recess, -1: none
};

AxisLines axis_lines(double half, double inner, double recess, const RoundedBoxOptions& options) {
  AxisLines lines;
  const double radius = options.radius_m, arc = radius * std::numbers::pi / 4;
  const auto add = [&](double at, double along) {
    lines.at_m.push_back(at);
    lines.uv.push_back(along);
  };
  // Equal angles along the rounding; uv follows the length on the surface.
  if (radius > 0)
    for (int k = options.segments; k > 0; --k) {
      const double share = static_cast<double>(k) / options.segments;
      const double tangent = k == options.segments ? 1 : std::tan(share * std::numbers::pi / 4);
      add(k == options.segments ? -half : -(inner + radius * tangent), -(inner + share * arc));
    }
  if (inner > 0) {
    add(-inner, -inner);
    lines.recess = recess > 0 ? static_cast<int>(lines.at_m.size()) : -1;
    if (recess > 0) add(-recess, -recess);
  } else {
    add(0, 0);
  }
  const auto below = static_cast<int>(lines.at_m.size());
  for (int k = inner > 0 ? below - 1 : below - 2; k >= 0; --k) add(-lines.at_m[k], -lines.uv[k]);
  for (double& u : lines.uv) u = 0.5 + 0.5 * u / (inner + arc);
  return lines;
}

struct Face {
  int normal, u, v;  ///< axes; u x v = sign * normal once u is mirrored for sign < 0
  double sign;
};
// v is the axis that should look upwards on the texture.
constexpr std::array<Face, 6> kFaces = {
    {{0, 1, 2, 1}, {0, 1, 2, -1}, {1, 0, 2, -1}, {1, 0, 2, 1}, {2, 0, 1, 1}, {2, 0, 1, -1}}};
// u x v along +normal: y x z = x, x x z = -y, x x y = z.
constexpr bool mirrored(const Face& face) {
  return (face.normal == 1) ? face.sign > 0 : face.sign < 0;
}

struct Form {
  Eigen::Vector3d half, inner;
  std::array<AxisLines, 3> lines;
  double radius, recess_depth;
};

Vertex surface_vertex(const Form& form, const Face& face, int i, int j) {
  const auto& u = form.lines[face.u];
  const auto& v = form.lines[face.v];
  const int last_u = static_cast<int>(u.at_m.size()) - 1;
  Eigen::Vector3d p;
  p[face.normal] = face.sign * form.half[face.normal];
  p[face.u] = u.at_m[mirrored(face) ? last_u - j : j];  // the lines are symmetric: mirrored is negated
  p[face.v] = v.at_m[i];
  const Eigen::Vector2d uv(u.uv[j], 1 - v.uv[i]);
  const Eigen::Vector3d core = p.cwiseMax(-form.inner).cwiseMin(form.inner);
  Eigen::Vector3d normal = p - core;
  if (form.radius == 0) return {p, face.sign * Eigen::Vector3d::Unit(face.normal), uv};
  normal.normalize();
  return {core + form.radius * normal, normal, uv};
}

void add_recess(Mesh& mesh, const Form& form, const Face& face) {
  const int i = form.lines[face.v].recess, j = form.lines[face.u].recess;
  const std::array<Vertex, 4> rim = {surface_vertex(form, face, i, j), surface_vertex(form, face, i, j + 1),
                                     surface_vertex(form, face, i + 1, j + 1),
                                     surface_vertex(form, face, i + 1, j)};
  std::array<Eigen::Vector3d, 4> floor;
  for (int k = 0; k < 4; ++k) floor[k] = rim[k].position - form.recess_depth * rim[k].normal;
  add_quad(mesh, floor[0], floor[1], floor[2], floor[3],
           {Eigen::Vector2d(rim[0].uv.x(), rim[2].uv.y()), Eigen::Vector2d(rim[1].uv.x(), rim[0].uv.y())});
  for (int k = 0; k < 4; ++k)
    add_quad(mesh, floor[k], rim[k].position, rim[(k + 1) % 4].position, floor[(k + 1) % 4]);
}

Form make_form(const Eigen::Vector3d& size_m, const RoundedBoxOptions& options) {
  Form form;
  form.half = size_m / 2;
  form.radius = options.radius_m;
  assert(form.radius <= form.half.minCoeff());
  form.inner = form.half.array() - form.radius;
  form.recess_depth = options.recess_depth_m;
  for (int k = 0; k < 3; ++k) {
    const double recess = options.recess_depth_m > 0 ? options.recess_share * form.inner[k] : 0;
    form.lines[k] = axis_lines(form.half[k], form.inner[k], recess, options);
  }
  return form;
}

}  // namespace

std::vector<Mesh> rounded_box(const Eigen::Vector3d& size_m, const RoundedBoxOptions& options,
                              const Material& material) {
  const Form form = make_form(size_m, options);
  std::vector<Mesh> meshes;
  for (const Face& face : kFaces) {
    Mesh mesh;
    const auto& u = form.lines[face.u];
    const auto& v = form.lines[face.v];
    const bool recessed = u.recess >= 0 && v.recess >= 0;
    add_grid(
        mesh, static_cast<int>(v.at_m.size()) - 1, static_cast<int>(u.at_m.size()) - 1,
        [&](int i, int j) { return surface_vertex(form, face, i, j); },
        [&](int i, int j) { return recessed && i == v.recess && j == u.recess; });
    if (recessed) add_recess(mesh, form, face);
    mesh.texture =
        paint_texture(material, static_cast<std::uint32_t>(meshes.size()), size_m[face.u], size_m[face.v]);
    meshes.push_back(std::move(mesh));
  }
  return meshes;
}

std::vector<Mesh> ellipsoid(const Eigen::Vector3d& size_m, int segments, const Material& material) {
  RoundedBoxOptions options;
  options.radius_m = 1;
  options.segments = segments;
  auto meshes = rounded_box(Eigen::Vector3d::Constant(2), options, material);
  fit_to_box(meshes, size_m);
  return meshes;
}

}  // namespace uniquadric
