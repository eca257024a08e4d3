#include "core/geometry/camera.h"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <tuple>

namespace uniquadric {
namespace {

constexpr int kMaxNewtonSteps = 30;
constexpr double kNewtonTolerance = 1e-13;  // normalised image plane; 1e-10 px at any usual focal length
constexpr double kLeastView_deg = 2, kMostView_deg = 170;  // ours: wider than pinhole lenses

Eigen::Vector2d distort(const Eigen::Vector2d& p, const std::array<double, 5>& d) {
  const double r2 = p.squaredNorm();
  const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  return {p.x() * radial + 2 * d[2] * p.x() * p.y() + d[3] * (r2 + 2 * p.x() * p.x()),
          p.y() * radial + d[2] * (r2 + 2 * p.y() * p.y()) + 2 * d[3] * p.x() * p.y()};
}

Eigen::Matrix2d distort_jacobian(const Eigen::Vector2d& p, const std::array<double, 5>& d) {
  const double r2 = p.squaredNorm();
  const double radial = 1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]));
  const double slope = 2 * (d[0] + r2 * (2 * d[1] + 3 * r2 * d[4]));  // d radial = slope * (x dx + y dy)
  Eigen::Matrix2d J;
  J(0, 0) = radial + slope * p.x() * p.x() + 2 * d[2] * p.y() + 6 * d[3] * p.x();
  J(0, 1) = slope * p.x() * p.y() + 2 * d[2] * p.x() + 2 * d[3] * p.y();
  J(1, 0) = J(0, 1);
  J(1, 1) = radial + slope * p.y() * p.y() + 6 * d[2] * p.y() + 2 * d[3] * p.x();
  return J;
}

}  // namespace

bool Camera::has_distortion() const {
  return std::any_of(distortion.begin(), distortion.end(), [](double k) { return k != 0; });
}

Eigen::Matrix3d Camera::matrix() const {
  Eigen::Matrix3d K;
  K << fx, 0, cx, 0, fy, cy, 0, 0, 1;
  return K;
}

bool Camera::contains(const Eigen::Vector2d& pixel) const {
  return pixel.x() >= -0.5 && pixel.y() >= -0.5 && pixel.x() <= width - 0.5 && pixel.y() <= height - 0.5;
}

std::optional<Eigen::Vector2d> Camera::project(const Eigen::Vector3d& point) const {
  if (!(point.z() > 0)) return std::nullopt;
  Eigen::Vector2d p = point.head<2>() / point.z();
  if (has_distortion()) p = distort(p, distortion);
  return Eigen::Vector2d(fx * p.x() + cx, fy * p.y() + cy);
}

std::optional<Eigen::Vector3d> Camera::unproject(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d wanted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  if (!has_distortion()) return Eigen::Vector3d(wanted.x(), wanted.y(), 1);
  Eigen::Vector2d p = wanted;
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Eigen::Vector2d error = distort(p, distortion) - wanted;
    if (error.norm() < kNewtonTolerance) return Eigen::Vector3d(p.x(), p.y(), 1);
    const Eigen::Matrix2d J = distort_jacobian(p, distortion);
    if (!(J.determinant() > 0)) return std::nullopt;  // past the fold of the radial polynomial
    p -= J.inverse() * error;
  }
  return std::nullopt;
}

Camera without_distortion(Camera camera) {
  camera.distortion = {};
  return camera;
}

std::vector<std::string> calibration_faults(const Camera& camera) {
  std::vector<std::string> faults;
  if (!camera.contains({camera.cx, camera.cy}))
    faults.push_back("the principal point lies outside the image");
  for (const auto& [size_px, focal_px, name] :
       {std::tuple(camera.width, camera.fx, "fx"), std::tuple(camera.height, camera.fy, "fy")}) {
    const double view_deg = 2 * std::atan2(size_px / 2.0, focal_px) * 180 / std::numbers::pi;
    if (view_deg < kLeastView_deg || view_deg > kMostView_deg)
      faults.push_back(
          fmt::format("{} of {} px gives an angle of view of {:.2g} degrees", name, focal_px, view_deg));
  }
  for (const double u : {0.0, camera.width - 1.0})
    for (const double v : {0.0, camera.height - 1.0})
      if (!camera.unproject({u, v}))
        faults.push_back(fmt::format("the distortion has no inverse at pixel ({}, {})", u, v));
  return faults;
}

}  // namespace uniquadric
