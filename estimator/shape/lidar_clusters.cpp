#include "estimator/shape/lidar_clusters.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "core/base/quantile.h"
#include "core/base/random.h"
#include "estimator/base/point_tree.h"
#include "estimator/shape/to_matrix.h"

namespace uniquadric {
namespace {

constexpr double kVoxelShare = 1.0 / 3;  // of the tolerance: points of one voxel hang together anyhow
constexpr double kRowSlack = 1.2;        // times the distance of two rows: a sensor sways, a body leans
constexpr double kElevationBin = 0.1 * std::numbers::pi / 180;  // [rad]: rows are wider apart
constexpr double kGrazing = 0.17;  // sine of 10 degrees between the line of sight and a side
constexpr int kRowBins = 4;        // of a row at most: what is broader are many beams
constexpr double kRowShare = 0.1;  // of the points in a bin of elevation on average: fewer are no row

// The number of a cell along an axis. Of places that no integer counts, and of none, that of a far one.
int cell_of(double place_m, double cell_m) {
  constexpr double kFar = 1e9;
  return static_cast<int>(std::fmax(-kFar, std::fmin(kFar, std::floor(place_m / cell_m))));
}

std::vector<Eigen::Vector3d> lowest_points(const Eigen::Matrix3Xd& points, double cell_m) {
  std::map<std::array<int, 2>, Eigen::Vector3d> lowest;
  for (const auto& p : points.colwise()) {
    const std::array<int, 2> cell{cell_of(p.x(), cell_m), cell_of(p.y(), cell_m)};
    const auto [at, is_new] = lowest.try_emplace(cell, p);
    if (!is_new && p.z() < at->second.z()) at->second = p;
  }
  std::vector<Eigen::Vector3d> result;
  for (const auto& [cell, point] : lowest) result.push_back(point);
  return result;
}

std::optional<GroundPlane> plane_through(const std::array<Eigen::Vector3d, 3>& p) {
  Eigen::Matrix3d rows;
  Eigen::Vector3d heights;
  for (int i = 0; i < 3; ++i) {
    rows.row(i) << p[i].x(), p[i].y(), 1;
    heights[i] = p[i].z();
  }
  Eigen::Matrix3d inverse;
  bool invertible = false;
  rows.computeInverseWithCheck(inverse, invertible, 1e-3);
  if (!invertible) return std::nullopt;
  const Eigen::Vector3d plane = inverse * heights;
  return GroundPlane{plane.head<2>(), plane.z()};
}

int root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

struct Voxels {
  std::vector<int> of_point;  // -1: of the ground
  std::vector<Eigen::Vector3d> means;
  std::vector<double> rises_m, reaches_m;  // across rows; along the line of sight
};

Voxels voxels_above(const Eigen::Matrix3Xd& points, const std::optional<GroundPlane>& ground,
                    const LidarClusterOptions& options, const BeamSpacing& spacing) {
  Voxels voxels;
  std::map<std::array<int, 3>, int> known;
  std::vector<int> counts;
  const double voxel_m = kVoxelShare * options.tolerance_m;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const auto p = points.col(i);
    voxels.of_point.push_back(-1);
    if (ground && ground->height_of(p) < options.ground_m) continue;
    const std::array<int, 3> key{cell_of(p.x(), voxel_m), cell_of(p.y(), voxel_m), cell_of(p.z(), voxel_m)};
    const auto [at, is_new] = known.try_emplace(key, static_cast<int>(counts.size()));
    if (is_new) {
      counts.push_back(0);
      voxels.means.emplace_back(Eigen::Vector3d::Zero());
      const auto at_point = [&](const std::vector<double>& all_m) {
        return all_m.empty() ? 0 : all_m[static_cast<std::size_t>(i)];
      };
      voxels.rises_m.push_back(std::min(kRowSlack * at_point(spacing.rises_m), options.max_rise_m));
      voxels.reaches_m.push_back(std::min(at_point(spacing.steps_m) / kGrazing, options.max_rise_m));
    }
    voxels.of_point.back() = at->second;
    voxels.means[at->second] += p;
    ++counts[at->second];
  }
  for (std::size_t i = 0; i < counts.size(); ++i) voxels.means[i] /= counts[i];
  return voxels;
}

// Which voxels hang together: the number of each one's part.
std::vector<int> parts_of(const Voxels& voxels, double tolerance_m, const Eigen::Vector3d& sensor) {
  const auto& means = voxels.means;
  const PointTree tree(to_matrix(means));
  std::vector<int> parent(means.size());
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<int> near;
  for (std::size_t i = 0; i < means.size(); ++i) {
    const Eigen::Vector2d sight = (means[i] - sensor).head<2>().normalized();
    tree.within(means[i], std::max({tolerance_m, voxels.rises_m[i], voxels.reaches_m[i]}), near);
    for (const int j : near) {
      Eigen::Vector3d apart = means[i] - means[j];
      if (apart.z() * apart.z() < voxels.rises_m[i] * voxels.rises_m[i]) apart.z() = 0;
      const double along_m = sight.dot(apart.head<2>());
      if (std::abs(along_m) < voxels.reaches_m[i]) apart.head<2>() -= along_m * sight;
      if (apart.squaredNorm() > tolerance_m * tolerance_m) continue;
      const int a = root(parent, static_cast<int>(i)), b = root(parent, j);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  for (std::size_t i = 0; i < parent.size(); ++i) parent[i] = root(parent, static_cast<int>(i));
  return parent;
}

// Of one row that is met, a body may be as high as the next one is away, and stand as far below.
bool is_body(const Eigen::Matrix3Xd& points, const std::vector<int>& cluster,
             const std::optional<GroundPlane>& ground, const std::vector<double>& rises_m,
             const LidarClusterOptions& options) {
  if (std::ssize(cluster) < options.min_points) return false;
  Eigen::Vector3d low = points.col(cluster.front()), high = low;
  for (const int i : cluster) low = low.cwiseMin(points.col(i)), high = high.cwiseMax(points.col(i));
  const Eigen::Vector3d size = high - low;
  const double rise_m = rises_m.empty() ? 0 : rises_m[static_cast<std::size_t>(cluster.front())];
  const auto stands = [&](int i) { return ground->height_of(points.col(i)) - rise_m < options.min_height_m; };
  if (ground && std::ranges::none_of(cluster, stands)) return false;
  return size.z() + rise_m >= options.min_height_m && size.head<2>().norm() <= options.max_extent_m;
}

}  // namespace

std::optional<GroundPlane> find_ground(const Eigen::Matrix3Xd& points, const LidarClusterOptions& options,
                                       std::uint64_t seed, std::int64_t scan) {
  const std::vector<Eigen::Vector3d> lowest = lowest_points(points, options.cell_m);
  if (lowest.size() < 3) return std::nullopt;
  RandomStream random(seed, "ground", static_cast<std::uint64_t>(scan));
  const double most_slope = std::tan(options.ground_tilt_deg * std::numbers::pi / 180);
  std::optional<GroundPlane> best;
  std::ptrdiff_t most = 2;
  const auto lies_on = [&](const GroundPlane& plane) {
    return std::count_if(lowest.begin(), lowest.end(), [&](const Eigen::Vector3d& p) {
      return std::abs(plane.height_of(p)) < options.ground_m / 2;
    });
  };
  for (int i = 0; i < options.ground_samples; ++i) {
    std::array<Eigen::Vector3d, 3> sample;
    for (auto& p : sample) p = lowest[random.below(static_cast<std::uint32_t>(lowest.size()))];
    const auto plane = plane_through(sample);
    if (!plane || plane->slope.norm() > most_slope) continue;
    if (const auto count = lies_on(*plane); count > most) best = plane, most = count;
  }
  return best;
}

std::vector<double> row_gaps(const std::vector<double>& elevations_rad) {
  const auto bin_of = [](double elevation) { return cell_of(elevation, kElevationBin); };
  std::map<int, int> counts;
  for (const double elevation : elevations_rad) ++counts[bin_of(elevation)];
  if (counts.empty()) return {};
  const double least =
      kRowShare * static_cast<double>(elevations_rad.size()) / static_cast<double>(counts.size());
  struct Row {
    int first, last;
    double middle() const { return kElevationBin * (first + last + 1) / 2; }
    bool is_one() const { return last - first < kRowBins; }
  };
  std::vector<Row> rows;  // bins without a gap
  for (const auto& [bin, count] : counts) {
    if (count < least) continue;
    if (rows.empty() || bin > rows.back().last + 1) rows.push_back({bin, bin});
    rows.back().last = bin;
  }
  std::vector<double> gaps;
  for (const double elevation : elevations_rad) {
    const auto next =
        std::find_if(rows.begin(), rows.end(), [&](const Row& row) { return row.last >= bin_of(elevation); });
    const auto row = next == rows.end() ? std::prev(rows.end()) : next;
    const auto gap_to = [&](const Row& other) {
      return row->is_one() && other.is_one() ? std::abs(row->middle() - other.middle()) : 0.0;
    };
    const double below = row != rows.begin() ? gap_to(*std::prev(row)) : 0;
    const double above = std::next(row) != rows.end() ? gap_to(*std::next(row)) : 0;
    gaps.push_back(std::max(below, above));
  }
  return gaps;
}

double beam_step(const std::vector<double>& azimuths_rad, const std::vector<double>& elevations_rad) {
  std::vector<std::pair<int, double>> beams;  // by level
  for (std::size_t i = 0; i < azimuths_rad.size(); ++i)
    beams.emplace_back(cell_of(elevations_rad[i], 2 * kElevationBin), azimuths_rad[i]);
  std::sort(beams.begin(), beams.end());
  std::vector<double> steps;
  for (std::size_t i = 1; i < beams.size(); ++i)
    if (beams[i].first == beams[i - 1].first) steps.push_back(beams[i].second - beams[i - 1].second);
  return steps.empty() ? 0 : upper_median(std::move(steps));
}

std::vector<std::vector<int>> clusters_above(const Eigen::Matrix3Xd& points,
                                             const std::optional<GroundPlane>& ground,
                                             const LidarClusterOptions& options, const BeamSpacing& spacing) {
  const Voxels voxels = voxels_above(points, ground, options, spacing);
  if (voxels.means.empty()) return {};
  const std::vector<int> parts = parts_of(voxels, options.tolerance_m, spacing.sensor);
  std::map<int, std::vector<int>> by_part;  // parts are named by their first voxel, voxels in points' order
  for (std::size_t i = 0; i < voxels.of_point.size(); ++i)
    if (voxels.of_point[i] >= 0) by_part[parts[voxels.of_point[i]]].push_back(static_cast<int>(i));
  std::vector<std::vector<int>> clusters;
  for (auto& [part, cluster] : by_part)
    if (is_body(points, cluster, ground, spacing.rises_m, options)) clusters.push_back(std::move(cluster));
  return clusters;
}

}  // namespace uniquadric
