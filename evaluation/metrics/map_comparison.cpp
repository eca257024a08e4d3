#include "evaluation/metrics/map_comparison.h"

#include <fmt/format.h>
#include <octomap/OcTree.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/sequence/ply.h"
#include "evaluation/metrics/octree_file.h"

namespace uniquadric {
namespace {

constexpr int kLevels = 16;  // of an OcTree below its root, which is centred at the world's origin
constexpr std::uint64_t kMostMissed = 30'000'000;  // ours: 20 s of looking at neighbours
constexpr double kPowerTolerance = 1e-6;           // of log2: edges are written with six digits at least

enum class Cell { unknown, free, occupied, mixed };

// The cube of 2^level voxels an edge with its lowest corner at 2^level * index voxels from the origin.
struct Cube {
  Eigen::Matrix<std::int64_t, 3, 1> index;
  int level = 0;
};

struct Map {
  std::shared_ptr<const octomap::OcTree> tree;
  int level = 0;  // in the tree, of a voxel

  Cell look(const Cube& cube) const {
    const int in_tree = cube.level + level;
    if (in_tree >= kLevels)
      return cube.index.minCoeff() >= -1 && cube.index.maxCoeff() <= 0 ? Cell::mixed : Cell::unknown;
    octomap::OcTreeKey key;
    for (int k = 0; k < 3; ++k) {
      const std::int64_t place = cube.index[k] * (std::int64_t(1) << in_tree) + (1 << (kLevels - 1));
      if (place < 0 || place >= 1 << kLevels) return Cell::unknown;
      key[static_cast<unsigned>(k)] = static_cast<octomap::key_type>(place);
    }
    const octomap::OcTreeNode* node = tree->search(key, static_cast<unsigned>(kLevels - in_tree));
    if (!node) return Cell::unknown;
    if (cube.level > 0 && tree->nodeHasChildren(node)) return Cell::mixed;
    return tree->isNodeOccupied(node) ? Cell::occupied
                                      : Cell::free;  // of one with children: if one of them is
  }
};

int level_of_voxels(const std::filesystem::path& path, const octomap::OcTree& tree, double resolution_m) {
  const double level = std::log2(resolution_m / tree.getResolution()), whole = std::round(level);
  if (!(std::abs(level - whole) <= kPowerTolerance && whole >= 0 && whole < kLevels))
    throw InputError(path, fmt::format("its cells of {} m, times a power of two, make no voxels of {} m",
                                       tree.getResolution(), resolution_m));
  return static_cast<int>(whole);
}

// Down both trees at once, as far as one of them goes on.
struct Walk {
  const std::filesystem::path& file;  // the estimate's
  Map truth, estimate;
  MapComparison result;
  std::uint64_t missed = 0;

  bool is_near(const Cube& voxel) const {
    for (int i = 0; i < 27; ++i)
      if (estimate.look({voxel.index + decltype(voxel.index)(i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1), 0}) ==
          Cell::occupied)
        return true;
    return false;
  }

  void visit(const Cube& cube) {
    const Cell t = truth.look(cube), e = estimate.look(cube);
    if (t == Cell::unknown && e == Cell::unknown) return;
    const bool is_missed =
        t == Cell::occupied && e != Cell::occupied;  // its voxels have neighbours of their own
    if (t == Cell::mixed || e == Cell::mixed || (is_missed && cube.level > 0)) {
      for (int child = 0; child < 8; ++child)
        visit({2 * cube.index + decltype(cube.index)(child & 1, child >> 1 & 1, child >> 2), cube.level - 1});
      return;
    }
    const std::uint64_t count = std::uint64_t(1) << 3 * cube.level;
    result.voxels[static_cast<std::size_t>(t)][static_cast<std::size_t>(e)] += count;
    if (is_missed && ++missed > kMostMissed)
      throw InputError(file,
                       fmt::format("misses more than {} occupied voxels: compare coarser ones", kMostMissed));
    if (t == Cell::occupied && (!is_missed || is_near(cube))) result.complete += count;
  }
};

MapComparison compare_trees(const std::filesystem::path& truth,
                            const std::shared_ptr<const octomap::OcTree>& true_tree,
                            const std::filesystem::path& estimate,
                            const std::shared_ptr<const octomap::OcTree>& tree, const MapOptions& options) {
  Walk walk{estimate, {}, {}, {}};
  walk.result.resolution_m =
      options.resolution_m.value_or(std::max(true_tree->getResolution(), tree->getResolution()));
  walk.truth = {true_tree, level_of_voxels(truth, *true_tree, walk.result.resolution_m)};
  walk.estimate = {tree, level_of_voxels(estimate, *tree, walk.result.resolution_m)};
  for (int octant = 0; octant < 8; ++octant)
    walk.visit({{-(octant & 1), -(octant >> 1 & 1), -(octant >> 2)}, kLevels - 1});
  const auto total = [&](Occupancy kind) {
    return walk.result.at(kind, Occupancy::unknown) + walk.result.at(kind, Occupancy::free) +
           walk.result.at(kind, Occupancy::occupied);
  };
  if (total(Occupancy::occupied) == 0) throw InputError(truth, "has no occupied voxel");
  walk.result.unknown_is_free = options.unknown_is_free.value_or(total(Occupancy::free) == 0);
  return walk.result;
}

std::shared_ptr<const octomap::OcTree> tree_of(const std::filesystem::path& file,
                                               const std::vector<Eigen::Vector3d>& points,
                                               double resolution_m) {
  auto tree = std::make_shared<octomap::OcTree>(resolution_m);
  for (const Eigen::Vector3d& p : points) {
    octomap::OcTreeKey key;
    if (!tree->coordToKeyChecked(p.x(), p.y(), p.z(), key))
      throw InputError(file, fmt::format("a point lies beyond {} m", resolution_m * (1 << (kLevels - 1))));
    tree->setNodeValue(key, tree->getClampingThresMaxLog(), true);
  }
  tree->updateInnerOccupancy();
  return tree;
}

}  // namespace

MapComparison compare_maps(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                           const MapOptions& options) {
  if (estimate.extension() == ".ply") {
    std::vector<Eigen::Vector3d> points;
    for (const Eigen::Vector3f& p : read_surface_ply(estimate).points) points.push_back(p.cast<double>());
    return compare_map_points(truth, estimate, points, options);
  }
  const auto true_tree = read_octree(truth);
  return compare_trees(truth, true_tree, estimate, read_octree(estimate), options);
}

MapComparison compare_map_points(const std::filesystem::path& truth, const std::filesystem::path& estimate,
                                 const std::vector<Eigen::Vector3d>& points, const MapOptions& options) {
  const auto true_tree = read_octree(truth);
  double resolution_m = true_tree->getResolution();
  while (!options.resolution_m && resolution_m < kPointVoxel_m) resolution_m *= 2;
  resolution_m = options.resolution_m.value_or(resolution_m);
  level_of_voxels(truth, *true_tree, resolution_m);  // before a tree of such voxels is made
  return compare_trees(truth, true_tree, estimate, tree_of(estimate, points, resolution_m), options);
}

Figures figures(const MapComparison& c) {
  using enum Occupancy;
  const std::uint64_t both = c.at(occupied, occupied);
  const std::uint64_t wrong = c.at(free, occupied) + (c.unknown_is_free ? c.at(unknown, occupied) : 0);
  const std::uint64_t unseen = c.at(occupied, unknown), missed = c.at(occupied, free) + unseen;
  const std::uint64_t known = both + missed + c.at(free, unknown) + c.at(free, free) + c.at(free, occupied);
  return {{"resolution_m", c.resolution_m},
          {"true_unknown_is", c.unknown_is_free ? "free" : "ignored"},
          {"true_known_voxels", known},
          {"true_occupied_voxels", both + missed},
          {"estimate_occupied_voxels", both + wrong},
          {"both_occupied_voxels", both},
          {"precision", share(both, both + wrong)},
          {"recall", share(both, both + missed)},
          {"iou", share(both, both + wrong + missed)},
          {"unknown_share", share(unseen + c.at(free, unknown), known)},
          {"completeness", share(c.complete, both + missed)}};
}

}  // namespace uniquadric
