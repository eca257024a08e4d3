#include "tests/estimator/depth_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace uniquadric {
namespace {

std::optional<double> cast_box(const Eigen::Vector3d& center, const Eigen::Vector3d& half,
                               const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
  const Eigen::Array3d a = (center - half - origin).array() / direction.array();
  const Eigen::Array3d b = (center + half - origin).array() / direction.array();
  const double enter = a.min(b).maxCoeff(), leave = a.max(b).minCoeff();
  if (enter < leave && enter > 0) return enter;
  return std::nullopt;
}

}  // namespace

RayBody box_body(const std::string& name, const Eigen::Vector3d& half) {
  return {name, half, [half](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) {
            return cast_box(Eigen::Vector3d::Zero(), half, origin, direction);
          }};
}

RayBody ellipsoid_body(const std::string& name, const Eigen::Vector3d& semi_axes) {
  return {
      name, semi_axes,
      [semi_axes](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) -> std::optional<double> {
        const Eigen::Vector3d o = origin.cwiseQuotient(semi_axes), d = direction.cwiseQuotient(semi_axes);
        const double a = d.squaredNorm(), b = o.dot(d), root = b * b - a * (o.squaredNorm() - 1);
        if (root <= 0) return std::nullopt;
        return (-b - std::sqrt(root)) / a;
      }};
}

RayBody skateboard_body() {
  return {"skateboard",
          {0.4, 0.1, 0.05},
          [](const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) -> std::optional<double> {
            double nearest = std::numeric_limits<double>::infinity();
            const auto part = [&](const Eigen::Vector3d& center, const Eigen::Vector3d& half) {
              nearest = std::min(nearest, cast_box(center, half, origin, direction).value_or(nearest));
            };
            part({0, 0, 0.04}, {0.4, 0.1, 0.01});
            for (const double x : {-0.25, 0.25})
              for (const double y : {-0.07, 0.07}) part({x, y, -0.02}, {0.03, 0.02, 0.03});
            if (std::isinf(nearest)) return std::nullopt;
            return nearest;
          }};
}

Pose arc_camera(int index, int count) {
  const double turn = 0.6 + (count > 1 ? 0.7 * index / (count - 1) : 0.35), up = 0.35;
  const Eigen::Vector3d back(std::cos(turn) * std::cos(up), std::sin(turn) * std::cos(up), std::sin(up));
  Eigen::Matrix3d R;
  R.col(2) = -back;
  R.col(0) = R.col(2).cross(Eigen::Vector3d::UnitZ()).normalized();
  R.col(1) = R.col(2).cross(R.col(0));
  return {Eigen::Quaterniond(R), 2.2 * back};
}

Eigen::Matrix3Xd depth_view(const RayBody& body, const Pose& body_from_camera,
                            const DepthViewOptions& options, RandomStream& random) {
  std::vector<Eigen::Vector3d> points;
  const auto normal3 = [&] { return Eigen::Vector3d(random.normal(), random.normal(), random.normal()); };
  const Eigen::Vector3d shift = options.pose_noise_m * normal3();
  for (int v = -120; v <= 120; v += 2)
    for (int u = -120; u <= 120; u += 2) {
      const Eigen::Vector3d ray(u / 525.0 + 1e-9, v / 525.0 + 1e-9, 1);
      const auto z = body.cast(body_from_camera.translation, body_from_camera.rotation * ray);
      if (!z) continue;
      Eigen::Vector3d p = ray * (*z * (1 + options.noise_per_range * random.normal())) + shift;
      if (random.uniform() < options.outliers)
        p = body_from_camera.inverse() *
            Eigen::Vector3d(random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5), random.uniform(-0.5, 0.5));
      points.push_back(p);
    }
  return Eigen::Map<const Eigen::Matrix3Xd>(points.data()->data(), 3,
                                            static_cast<Eigen::Index>(points.size()));
}

}  // namespace uniquadric
