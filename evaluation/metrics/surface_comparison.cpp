#include "evaluation/metrics/surface_comparison.h"

#include <fmt/format.h>

#include <algorithm>

#include "core/base/error.h"
#include "core/sequence/pcd.h"

namespace uniquadric {

SurfaceComparison compare_to_surface(const std::filesystem::path& points, const SurfaceDistance& surface,
                                     const SurfaceOptions& options) {
  const PcdFile file = read_pcd(points);
  const PcdColumn x = pcd_column(points, file, "x", 'F', 4), y = pcd_column(points, file, "y", 'F', 4),
                  z = pcd_column(points, file, "z", 'F', 4);
  const Pose surface_from_points = options.points_from_surface.inverse();
  SurfaceComparison result;
  result.within_m = options.within_m;
  std::vector<double> distances_m;
  for (std::int64_t i = 0; i < file.points; ++i) {
    const Eigen::Vector3d point(x.at<float>(i), y.at<float>(i), z.at<float>(i));
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
