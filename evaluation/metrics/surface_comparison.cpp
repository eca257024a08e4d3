#include "evaluation/metrics/surface_comparison.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/sequence/pcd.h"
#include "core/sequence/ply.h"

namespace uniquadric {
namespace {

std::vector<Eigen::Vector3f> read_pcd_points(const std::filesystem::path& path) {
  const PcdFile file = read_pcd(path);
  const PcdColumn x = pcd_column(path, file, "x", 'F', 4), y = pcd_column(path, file, "y", 'F', 4),
                  z = pcd_column(path, file, "z", 'F', 4);
  std::vector<Eigen::Vector3f> points;
  for (std::int64_t i = 0; i < file.points; ++i)
    points.emplace_back(x.at<float>(i), y.at<float>(i), z.at<float>(i));
  return points;
}

}  // namespace

SurfaceComparison compare_to_surface(const std::filesystem::path& points, const SurfaceDistance& surface,
                                     const SurfaceOptions& options) {
  const Pose surface_from_points = options.points_from_surface.inverse();
  SurfaceComparison result;
  result.within_m = options.within_m;
  std::vector<double> distances_m;
  const std::vector<Eigen::Vector3f> all =
      points.extension() == ".ply" ? read_surface_ply(points).points : read_pcd_points(points);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Eigen::Vector3d point = all[i].cast<double>();
    if (point.allFinite() && point.cwiseAbs().maxCoeff() > kMostCoordinate_m)
      throw InputError(points, fmt::format("point {} lies beyond {} m", i, kMostCoordinate_m));
    if (point.allFinite())
      distances_m.push_back(surface.at(surface_from_points * point));
    else
      ++result.not_finite;
  }
  if (distances_m.empty()) throw InputError(points, "has no finite point");
  result.distance_m = *statistics(distances_m);
  const auto within = std::count_if(distances_m.begin(), distances_m.end(),
                                    [&](double distance_m) { return distance_m <= options.within_m; });
  result.share_within = share(static_cast<std::uint64_t>(within), distances_m.size());
  result.quantile_95_m = interpolated_quantile(std::move(distances_m), 0.95);
  return result;
}

Figures figures(const SurfaceComparison& c) {
  return {{"n", std::uint64_t(c.distance_m.n)},
          {"not_finite", c.not_finite},
          {"rmse_m", c.distance_m.rmse},
          {"mean_m", c.distance_m.mean},
          {"median_m", c.distance_m.median},
          {"quantile_95_m", c.quantile_95_m},
          {"within_m", c.within_m},
          {"share_within", c.share_within}};
}

}  // namespace uniquadric
