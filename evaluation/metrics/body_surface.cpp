#include "evaluation/metrics/body_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cassert>

#include "evaluation/metrics/surface_error.h"

namespace uniquadric {
namespace {

constexpr std::uint32_t kCells = 12;      // along an edge of the box
constexpr std::size_t kPoints = 384;      // ours: of each surface
constexpr double kLeastExponent = 1.001;  // below, the gauge's powers have no numbers; 0.1 % of a box
constexpr double kLeastTolerance_m = 0.01, kTolerance = 0.01;

// Onto the body, along the line to its centre; corners of a side of its box lie outside or on it.
Eigen::Vector3d on_body(const Superellipsoid& body, const Eigen::Vector3d& point) {
  return point / gauge(body, point);
}

struct Nearness {
  double share_within = 0, mean_m = 0;
};

Nearness nearness(const std::vector<Eigen::Vector3d>& points, const Pose& other_from_points,
                  const SurfaceDistance& other, double within_m) {
  assert(!points.empty());
  Nearness result;
  for (const Eigen::Vector3d& point : points) {
    const double distance_m = other.at(other_from_points * point);
    result.share_within += distance_m <= within_m ? 1 : 0;
    result.mean_m += distance_m;
  }
  const double n = static_cast<double>(points.size());
  return {result.share_within / n, result.mean_m / n};
}

}  // namespace

SurfaceFile tessellate(const Superellipsoid& body) {
  Superellipsoid smooth = body;
  for (double* exponent : {&smooth.exponents.outline, &smooth.exponents.upper, &smooth.exponents.lower})
    *exponent = std::max(*exponent, kLeastExponent);
  SurfaceFile mesh;
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1.0, 1.0}) {
      const auto first = static_cast<std::uint32_t>(mesh.points.size());
      for (std::uint32_t i = 0; i <= kCells; ++i)
        for (std::uint32_t j = 0; j <= kCells; ++j) {
          Eigen::Vector3d unit;
          unit[axis] = side;
          unit[(axis + 1) % 3] = 2.0 * i / kCells - 1;
          unit[(axis + 2) % 3] = 2.0 * j / kCells - 1;
          const Eigen::Vector3d point = unit.cwiseProduct(body.semi_axes_m);
          mesh.points.emplace_back((is_box(body) ? point : on_body(smooth, point)).cast<float>());
        }
      for (std::uint32_t i = 0; i < kCells; ++i)
        for (std::uint32_t j = 0; j < kCells; ++j) {
          const std::uint32_t a = first + i * (kCells + 1) + j, b = a + kCells + 1;
          mesh.triangles.push_back({a, b, b + 1});
          mesh.triangles.push_back({a, b + 1, a + 1});
        }
    }
  return mesh;
}

ReferenceSurface reference_surface(const SurfaceFile& mesh) {
  return {SurfaceDistance(mesh.points, mesh.triangles), sample_surface(mesh, kPoints)};
}

SurfaceScore surface_score(const ReferenceSurface& truth, const ReferenceSurface& estimate,
                           const Pose& truth_from_estimate, double within_m) {
  const Nearness precision = nearness(estimate.points, truth_from_estimate, truth.distance, within_m);
  const Nearness recall = nearness(truth.points, truth_from_estimate.inverse(), estimate.distance, within_m);
  const double sum = precision.share_within + recall.share_within;
  return {sum > 0 ? 2 * precision.share_within * recall.share_within / sum : 0,
          (precision.mean_m + recall.mean_m) / 2};
}

double surface_tolerance_m(const SurfaceFile& truth) {
  const Eigen::AlignedBox3d box = surface_box(truth);
  return std::max(kLeastTolerance_m, box.isEmpty() ? 0 : kTolerance * box.sizes().maxCoeff());
}

}  // namespace uniquadric
