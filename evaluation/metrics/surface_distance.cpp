#include "evaluation/metrics/surface_distance.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/embree/embree.h"
#include "core/embree/rtcore_parts.h"

namespace uniquadric {

struct SurfaceDistance::State {
  std::vector<Eigen::Vector3f> corners;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  Eigen::AlignedBox3d box;
  EmbreeDevice device = new_embree_device("");
  EmbreeScene scene = new_embree_scene(device.get());
};

namespace {

constexpr double kFar = 1000;  // ours: sizes of the surface, beyond which its box stands for it

// The nearest point lies inside the triangle, or on one of its sides.
double to_triangle_m(const Eigen::Vector3d& p, const std::array<Eigen::Vector3d, 3>& corners) {
  const Eigen::Vector3d across = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  bool inside = across.squaredNorm() > 0;
  double nearest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d from = corners[i], side = corners[(i + 1) % 3] - from;
    const double share = std::clamp(side.dot(p - from) / std::max(side.squaredNorm(), 1e-300), 0.0, 1.0);
    nearest = std::min(nearest, (p - from - share * side).norm());
    inside = inside && across.dot(side.cross(p - from)) >= 0;
  }
  return inside ? std::abs(across.normalized().dot(p - corners[0])) : nearest;
}

struct Query {
  const std::vector<Eigen::Vector3f>& corners;
  const std::vector<std::array<std::uint32_t, 3>>& triangles;
  Eigen::Vector3d point;
  double nearest_m;
};

// Radius of a query about the rounded point within which every triangle lies that is no farther off than
// this.
float reach(const Eigen::Vector3d& point, double distance_m) {
  constexpr double kRounding = 1e-6;  // ours: some last places of a float
  return static_cast<float>(distance_m + kRounding * (distance_m + point.cwiseAbs().maxCoeff()));
}

bool look_at_triangle(RTCPointQueryFunctionArguments* arguments) {
  Query& query = *static_cast<Query*>(arguments->userPtr);
  std::array<Eigen::Vector3d, 3> corners;
  for (int i = 0; i < 3; ++i)
    corners[i] = query.corners[query.triangles[arguments->primID][i]].cast<double>();
  const double distance_m = to_triangle_m(query.point, corners);
  if (distance_m >= query.nearest_m) return false;
  query.nearest_m = distance_m;
  const float radius = reach(query.point, distance_m);
  if (radius >= arguments->query->radius) return false;
  arguments->query->radius = radius;
  return true;
}

}  // namespace

SurfaceDistance::SurfaceDistance(std::vector<Eigen::Vector3f> corners,
                                 std::vector<std::array<std::uint32_t, 3>> triangles) {
  auto state = std::make_shared<State>();
  state->corners = std::move(corners);
  state->triangles = std::move(triangles);
  for (const auto& triangle : state->triangles)
    for (const std::uint32_t corner : triangle) state->box.extend(state->corners[corner].cast<double>());
  attach_triangles(state->device.get(), state->scene.get(), state->corners, state->triangles);
  commit_embree_scene(state->device.get(), state->scene);
  state_ = std::move(state);
}

std::optional<double> SurfaceDistance::along(const Eigen::Vector3d& from,
                                             const Eigen::Vector3d& direction) const {
  const Eigen::Vector3f p = from.cast<float>(), d = direction.cast<float>();
  RTCRayHit ray{};
  ray.ray.org_x = p.x(), ray.ray.org_y = p.y(), ray.ray.org_z = p.z();
  ray.ray.dir_x = d.x(), ray.ray.dir_y = d.y(), ray.ray.dir_z = d.z();
  ray.ray.tfar = std::numeric_limits<float>::infinity();
  ray.ray.mask = ~0U;
  ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  intersect(state_->scene.get(), ray);
  if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return ray.ray.tfar;
}

double SurfaceDistance::at(const Eigen::Vector3d& point, double most_m) const {
  // From far away every triangle is as near, and all would be looked at.
  const double to_box_m = state_->box.exteriorDistance(point);
  if (to_box_m > kFar * state_->box.diagonal().norm()) return std::min(most_m, to_box_m);
  Query query{state_->corners, state_->triangles, point, most_m};
  const Eigen::Vector3f p = point.cast<float>();
  RTCPointQuery around{p.x(), p.y(), p.z(), 0, reach(point, most_m)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  rtcPointQuery(state_->scene.get(), &around, &context, look_at_triangle, &query);
  return query.nearest_m;
}

}  // namespace uniquadric
