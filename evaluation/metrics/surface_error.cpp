#include "evaluation/metrics/surface_error.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "evaluation/metrics/surface_distance.h"

namespace uniquadric {
namespace {

using Triangles = std::vector<std::array<std::uint32_t, 3>>;

Eigen::Vector3d corner(const SurfaceFile& mesh, std::size_t triangle, int k) {
  return mesh.points[mesh.triangles[triangle][k]].cast<double>();
}

double area(const SurfaceFile& mesh, std::size_t triangle) {
  const Eigen::Vector3d a = corner(mesh, triangle, 0);
  return (corner(mesh, triangle, 1) - a).cross(corner(mesh, triangle, 2) - a).norm() / 2;
}

// Each point as a triangle without extent.
SurfaceDistance distance_to(const std::vector<Eigen::Vector3d>& points) {
  std::vector<Eigen::Vector3f> corners;
  Triangles triangles;
  for (const Eigen::Vector3d& p : points) {
    const auto i = static_cast<std::uint32_t>(corners.size());
    triangles.push_back({i, i, i});
    corners.push_back(p.cast<float>());
  }
  return {std::move(corners), std::move(triangles)};
}

}  // namespace

Eigen::AlignedBox3d surface_box(const SurfaceFile& mesh) {
  Eigen::AlignedBox3d box;
  for (const auto& triangle : mesh.triangles)
    for (const std::uint32_t point : triangle) box.extend(mesh.points[point].cast<double>());
  return box;
}

// Equal steps along the triangles' areas laid end to end; in the triangle the R2 sequence (Roberts, "The
// unreasonable effectiveness of quasirandom sequences", 2018), folded.
std::vector<Eigen::Vector3d> sample_surface(const SurfaceFile& mesh, std::size_t samples) {
  constexpr double kPlastic = 1.32471795724474602596;
  std::vector<double> ends;
  double whole = 0;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) ends.push_back(whole += area(mesh, i));
  std::vector<Eigen::Vector3d> points;
  if (!(whole > 0)) return points;
  std::size_t triangle = 0;
  for (std::size_t i = 0; i < samples; ++i) {
    const double place = (static_cast<double>(i) + 0.5) / static_cast<double>(samples) * whole;
    while (triangle + 1 < ends.size() && ends[triangle] <= place) ++triangle;
    double u = std::fmod(0.5 + static_cast<double>(i) / kPlastic, 1);
    double v = std::fmod(0.5 + static_cast<double>(i) / (kPlastic * kPlastic), 1);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Eigen::Vector3d a = corner(mesh, triangle, 0);
    points.push_back(a + u * (corner(mesh, triangle, 1) - a) + v * (corner(mesh, triangle, 2) - a));
  }
  return points;
}

std::optional<SurfaceError> surface_error(const SurfaceFile& truth, const SurfaceFile& estimate,
                                          const Pose& truth_from_estimate, double scale) {
  std::vector<Eigen::Vector3d> points;
  if (estimate.triangles.empty())
    for (const Eigen::Vector3f& p : estimate.points) points.push_back(p.cast<double>());
  else
    points = sample_surface(estimate, kSurfaceSamples);
  const std::vector<Eigen::Vector3d> true_points = sample_surface(truth, kSurfaceSamples);
  if (points.empty() || true_points.empty()) return std::nullopt;
  for (Eigen::Vector3d& p : points) p = truth_from_estimate * (scale * p).eval();

  SurfaceError result;
  const SurfaceDistance true_surface(truth.points, truth.triangles);
  std::vector<double> errors_m;
  for (const Eigen::Vector3d& p : points) errors_m.push_back(true_surface.at(p));
  result.points_from_truth = truth_from_estimate.inverse();
  result.error_m = *statistics(errors_m);
  result.quantile_90_m = interpolated_quantile(std::move(errors_m), 0.9);
  result.within_m = kWithinDiagonal * surface_box(truth).diagonal().norm();
  const SurfaceDistance cloud = distance_to(points);
  const auto found = std::count_if(true_points.begin(), true_points.end(), [&](const Eigen::Vector3d& p) {
    return cloud.at(p, result.within_m) < result.within_m;
  });
  result.completeness = static_cast<double>(found) / static_cast<double>(true_points.size());
  return result;
}

}  // namespace uniquadric
