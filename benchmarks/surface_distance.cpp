#include "benchmarks/surface_distance.h"

#include <embree3/rtcore.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace uniquadric {

struct SurfaceDistance::State {
  std::vector<Mesh> meshes;  // geometry ids of the scene in their order
  RTCDevice device = rtcNewDevice(nullptr);
  RTCScene scene = rtcNewScene(device);
  ~State() {
    rtcReleaseScene(scene);
    rtcReleaseDevice(device);
  }
};

namespace {

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

bool look_at_triangle(RTCPointQueryFunctionArguments* arguments) {
  const Mesh& mesh = (*static_cast<const std::vector<Mesh>*>(arguments->userPtr))[arguments->geomID];
  std::array<Eigen::Vector3d, 3> corners;
  for (int i = 0; i < 3; ++i)
    corners[i] = mesh.positions[mesh.triangles[arguments->primID][i]].cast<double>();
  RTCPointQuery& query = *arguments->query;
  const auto distance = static_cast<float>(to_triangle_m({query.x, query.y, query.z}, corners));
  if (distance >= query.radius) return false;
  query.radius = distance;
  return true;
}

void add_mesh(RTCDevice device, RTCScene scene, const Mesh& mesh, unsigned id) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0,
                                                               RTC_FORMAT_FLOAT3, 12, mesh.positions.size()));
  for (const Eigen::Vector3f& v : mesh.positions) vertices = std::copy_n(v.data(), 3, vertices);
  auto* corners = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
  for (const auto& triangle : mesh.triangles) corners = std::copy_n(triangle.data(), 3, corners);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, id);
  rtcReleaseGeometry(geometry);
}

}  // namespace

SurfaceDistance::SurfaceDistance(const std::vector<Mesh>& meshes) {
  auto state = std::make_shared<State>();
  state->meshes = meshes;
  for (std::size_t i = 0; i < meshes.size(); ++i)
    add_mesh(state->device, state->scene, meshes[i], static_cast<unsigned>(i));
  rtcCommitScene(state->scene);
  state_ = std::move(state);
}

double SurfaceDistance::at(const Eigen::Vector3d& point, double most_m) const {
  const Eigen::Vector3f p = point.cast<float>();
  RTCPointQuery query{p.x(), p.y(), p.z(), 0, static_cast<float>(most_m)};
  RTCPointQueryContext context;
  rtcInitPointQueryContext(&context);
  auto* meshes = const_cast<std::vector<Mesh>*>(&state_->meshes);
  rtcPointQuery(state_->scene, &query, &context, look_at_triangle, meshes);
  return query.radius;
}

}  // namespace uniquadric
