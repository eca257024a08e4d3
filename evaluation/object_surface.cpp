#include "evaluation/object_surface.h"

#include <fmt/format.h>

#include "core/base/error.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

fs::path surface_file_of(const fs::path& folder, int id) {
  return folder / "objects" / fmt::format("{}.ply", id);
}

SurfaceFile box_surface(const Eigen::Vector3d& semi_axes_m) {
  SurfaceFile box;
  for (int i = 0; i < 8; ++i)
    box.points.push_back(
        semi_axes_m.cwiseProduct(Eigen::Vector3d(i & 1 ? 1 : -1, i & 2 ? 1 : -1, i & 4 ? 1 : -1))
            .cast<float>());
  for (std::uint32_t axis = 1; axis < 8; axis *= 2) {
    const std::uint32_t u = axis == 4 ? 1 : 2 * axis, v = 7 - axis - u;
    for (const std::uint32_t side : {0U, axis})
      box.triangles.insert(box.triangles.end(),
                           {{side, side + u, side + u + v}, {side, side + u + v, side + v}});
  }
  return box;
}

}  // namespace

std::optional<SurfaceFile> true_surface_of_file(const fs::path& truth, const ObjectDescription& object) {
  const fs::path file = surface_file_of(truth, object.id);
  if (!fs::exists(file)) return std::nullopt;
  SurfaceFile surface = read_surface_ply(file);
  if (surface.triangles.empty()) throw InputError(file, "has no faces: a true surface is a mesh");
  return surface;
}

std::optional<SurfaceFile> true_surface(const fs::path& truth, const ObjectDescription& object) {
  if (auto surface = true_surface_of_file(truth, object)) return surface;
  return object.shape == "box" ? std::optional(box_surface(object.semi_axes_m)) : std::nullopt;
}

std::optional<SurfaceFile> kept_points(const fs::path& estimate, const ObjectEvaluation& object) {
  if (!object.matched_id || !object.truth_from_body) return std::nullopt;
  const fs::path file = surface_file_of(estimate, *object.matched_id);
  return fs::exists(file) ? std::optional(read_surface_ply(file)) : std::nullopt;
}

}  // namespace uniquadric
