#include "tests/simulator/ray_cast.h"

#include <Eigen/Geometry>
#include <algorithm>

namespace uniquadric {
namespace {

// (distance along the ray, least barycentric coordinate)
std::optional<std::pair<double, double>> intersect(const Eigen::Vector3d& ray, const Eigen::Vector3d& a,
                                                   const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
  const Eigen::Vector3d ab = b - a, ac = c - a, p = ray.cross(ac);
  const double determinant = ab.dot(p);
  if (determinant == 0) return std::nullopt;
  const double u = -a.dot(p) / determinant;
  const Eigen::Vector3d q = (-a).cross(ab);
  const double v = ray.dot(q) / determinant, t = ac.dot(q) / determinant;
  const double least = std::min({u, v, 1 - u - v});
  if (least < 0 || t <= 0) return std::nullopt;
  return std::pair{t, least};
}

void cast(const Body& body, const Pose& camera_from_body, const Eigen::Vector3d& ray,
          std::optional<RayHit>& best) {
  for (const Mesh& mesh : body.meshes)
    for (const auto& [i, j, k] : mesh.triangles) {
      const auto corner = [&](unsigned n) { return camera_from_body * mesh.positions[n].cast<double>(); };
      const auto hit = intersect(ray, corner(i), corner(j), corner(k));
      if (hit && (!best || hit->first < best->z_m)) best = RayHit{hit->first, body.id, hit->second};
    }
}

}  // namespace

std::optional<RayHit> cast_ray(const Scene& scene, const ScenePoses& poses, double u, double v) {
  const auto ray = scene.camera.unproject({u, v});  // its z is 1: t is z
  if (!ray) return std::nullopt;
  const Pose camera_from_world = poses.world_from_camera.inverse();
  std::optional<RayHit> best;
  for (const Body& body : scene.world) cast(body, camera_from_world * body.motion.at(0), *ray, best);
  for (std::size_t i = 0; i < scene.objects.size(); ++i)
    cast(scene.objects[i], camera_from_world * poses.world_from_object[i], *ray, best);
  return best;
}

}  // namespace uniquadric
