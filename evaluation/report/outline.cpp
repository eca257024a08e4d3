#include "evaluation/report/outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace uniquadric {
namespace {

constexpr int kTangents = 360;        // ours: chords under 0.02 px off a circle of 250 px
constexpr int kMostSteps = 50;        // ours: five or so are taken
constexpr double kLeastGain = 1e-12;  // ours: of a tangent; far below a pixel

// The point of the body that is furthest in a direction, all in the camera's frame.
Eigen::Vector3d furthest(const Pose& camera_from_object, const Superellipsoid& body,
                         const Eigen::Vector3d& direction) {
  return camera_from_object * support_point(body, camera_from_object.rotation.conjugate() * direction);
}

}  // namespace

// The tangent of direction u touches where u . (x, y) / z is greatest over the body. With d that ratio so
// far, the point furthest along (u, -d) has a greater one, until d is the greatest (Dinkelbach's iteration).
std::vector<Eigen::Vector2d> superellipsoid_outline(const Camera& camera, const Pose& camera_from_object,
                                                    const Superellipsoid& body) {
  std::vector<Eigen::Vector2d> outline;
  if (!(furthest(camera_from_object, body, -Eigen::Vector3d::UnitZ()).z() > 0)) return outline;
  for (int i = 0; i < kTangents; ++i) {
    const double angle = 2 * std::numbers::pi * i / kTangents;
    const Eigen::Vector2d u(std::cos(angle), std::sin(angle));
    Eigen::Vector2d touched = camera_from_object.translation.hnormalized();
    for (int step = 0; step < kMostSteps; ++step) {
      const Eigen::Vector3d direction(u.x(), u.y(), -u.dot(touched));
      const Eigen::Vector2d next = furthest(camera_from_object, body, direction).hnormalized();
      if (u.dot(next - touched) < kLeastGain) break;
      touched = next;
    }
    outline.emplace_back(camera.fx * touched.x() + camera.cx, camera.fy * touched.y() + camera.cy);
  }
  return outline;
}

}  // namespace uniquadric
