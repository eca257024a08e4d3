#include "estimator/ego/lidar_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace uniquadric {
namespace {

constexpr std::int32_t kBlockShift = 2, kBlockMask = 3;  // 4 cells along an edge

std::size_t index_in_block(const std::array<std::int32_t, 3>& cell) {
  return static_cast<std::size_t>((cell[0] & kBlockMask) | (cell[1] & kBlockMask) << kBlockShift |
                                  (cell[2] & kBlockMask) << 2 * kBlockShift);
}

std::array<std::int32_t, 3> block_of(const std::array<std::int32_t, 3>& cell) {
  return {cell[0] >> kBlockShift, cell[1] >> kBlockShift, cell[2] >> kBlockShift};
}

}  // namespace

struct LidarMapLevel::Neighbours {
  struct Near {
    double distance2 = 0;
    Eigen::Vector3d place = Eigen::Vector3d::Zero();  // of the mean, relative to the query
    const Cell* cell = nullptr;
  };
  int count = 0;
  std::array<Near, 27> cells;
};

LidarMapLevel::LidarMapLevel(const LidarMapOptions& options, int level)
    : options_(options), cell_m_(options.cell_m * (1 << level)) {}

// Teschner et al., "Optimized spatial hashing for collision detection of deformable objects", VMV 2003.
std::size_t LidarMapLevel::KeyHash::operator()(const std::array<std::int32_t, 3>& key) const {
  return static_cast<std::size_t>(key[0]) * 73856093U ^ static_cast<std::size_t>(key[1]) * 19349669U ^
         static_cast<std::size_t>(key[2]) * 83492791U;
}

std::array<std::int32_t, 3> LidarMapLevel::cell_of(const Eigen::Vector3d& p) const {
  const auto along = [&](int k) { return static_cast<std::int32_t>(std::floor(p[k] / cell_m_)); };
  return {along(0), along(1), along(2)};
}

const LidarMapLevel::Block* LidarMapLevel::find(const std::array<std::int32_t, 3>& block) const {
  const auto found = place_.find(block);
  return found == place_.end() ? nullptr : &blocks_[found->second];
}

void LidarMapLevel::add(const Eigen::Vector3d& p) {
  const auto cell = cell_of(p);
  const auto [found, is_new] = place_.try_emplace(block_of(cell), blocks_.size());
  if (is_new) blocks_.emplace_back().key = found->first;
  Block& block = blocks_[found->second];
  block.last_seen = time_;
  Cell& here = block.cells[index_in_block(cell)];
  if (here.count >= options_.max_count) return;
  ++here.count;
  const Eigen::Vector3d corner = cell_m_ * Eigen::Vector3d(cell[0], cell[1], cell[2]);
  const Eigen::Vector3f q = (p - corner).cast<float>(), before = q - here.mean;
  here.mean += before / static_cast<float>(here.count);
  const Eigen::Vector3f after = q - here.mean;  // Welford's recurrence
  here.square.head<3>() += before.cwiseProduct(after);
  here.square.tail<3>() +=
      Eigen::Vector3f(before.x() * after.y(), before.x() * after.z(), before.y() * after.z());
}

LidarMapLevel::Neighbours LidarMapLevel::neighbours_of(const Eigen::Vector3d& p) const {
  const auto centre = cell_of(p);
  // The 27 cells lie in at most eight blocks: the one of the lowest cell, and the next ones.
  const auto lowest = block_of({centre[0] - 1, centre[1] - 1, centre[2] - 1});
  std::array<const Block*, 8> blocks{};
  std::array<bool, 8> is_known{};
  Neighbours result;
  for (int k = 0; k < 27; ++k) {
    const std::array<std::int32_t, 3> cell = {centre[0] + k % 3 - 1, centre[1] + k / 3 % 3 - 1,
                                              centre[2] + k / 9 - 1};
    const auto key = block_of(cell);
    const auto which = static_cast<std::size_t>((key[0] - lowest[0]) | (key[1] - lowest[1]) << 1 |
                                                (key[2] - lowest[2]) << 2);
    if (!is_known[which]) blocks[which] = find(key), is_known[which] = true;
    const Block* block = blocks[which];
    if (!block) continue;
    const Cell& mean = block->cells[index_in_block(cell)];
    if (mean.count == 0) continue;
    const Eigen::Vector3d place =
        cell_m_ * Eigen::Vector3d(cell[0], cell[1], cell[2]) + mean.mean.cast<double>() - p;
    result.cells[static_cast<std::size_t>(result.count++)] = {place.squaredNorm(), place, &mean};
  }
  return result;
}

std::optional<MapPlane> LidarMapLevel::plane_near(const Eigen::Vector3d& p, const PlaneLimits& limits) const {
  Neighbours near = neighbours_of(p);
  if (near.count < options_.min_neighbours) return std::nullopt;
  const int n = std::min(near.count, options_.neighbours);
  if (n < near.count)
    std::nth_element(near.cells.begin(), near.cells.begin() + n, near.cells.begin() + near.count,
                     [](const auto& a, const auto& b) { return a.distance2 < b.distance2; });
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  double points = 0;
  for (int i = 0; i < n; ++i) {
    const auto& [distance2, q, cell] = near.cells[static_cast<std::size_t>(i)];
    const double count = cell->count;
    const Eigen::Matrix<double, 6, 1> own = cell->square.cast<double>();
    mean += count * q;
    square.noalias() += count * q * q.transpose();
    square.diagonal() += own.head<3>();
    square(1, 0) += own[3];
    square(2, 0) += own[4];
    square(2, 1) += own[5];
    points += count;
  }
  mean /= points;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;  // reads the lower triangle
  solver.computeDirect(square / points - mean * mean.transpose());
  const double least = std::max(solver.eigenvalues()[0], 0.0), middle = solver.eigenvalues()[1];
  if (least > limits.max_thickness_m * limits.max_thickness_m || middle < options_.min_flatness * least ||
      middle <= limits.min_breadth_m * limits.min_breadth_m)
    return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  MapPlane plane{normal, -normal.dot(p + mean), std::sqrt(least / points), std::sqrt(least)};
  for (int k = 0; k < 2; ++k)
    plane.normal_error.col(k) =
        std::sqrt(least / (points * solver.eigenvalues()[k + 1])) * solver.eigenvectors().col(k + 1);
  return plane;
}

void LidarMapLevel::remove(std::size_t block) {
  place_.erase(blocks_[block].key);
  if (block + 1 != blocks_.size()) {
    blocks_[block] = std::move(blocks_.back());
    place_[blocks_[block].key] = block;
  }
  blocks_.pop_back();
}

void LidarMapLevel::trim(const Eigen::Vector3d& centre) {
  ++time_;
  const double edge = cell_m_ * (kBlockMask + 1);
  for (std::size_t i = blocks_.size(); i-- > 0;) {
    const auto& key = blocks_[i].key;
    const Eigen::Vector3d middle = edge * (Eigen::Vector3d(key[0], key[1], key[2]).array() + 0.5);
    if ((middle - centre).norm() > options_.max_range_m) remove(i);
  }
  const auto most = static_cast<std::size_t>(options_.max_blocks);
  if (blocks_.size() <= most) return;
  std::vector<std::uint64_t> seen;
  for (const Block& block : blocks_) seen.push_back(block.last_seen);
  const auto oldest_kept = seen.begin() + static_cast<std::ptrdiff_t>(seen.size() - most);
  std::nth_element(seen.begin(), oldest_kept, seen.end());
  const std::uint64_t limit = *oldest_kept;
  for (std::size_t i = blocks_.size(); i-- > 0 && blocks_.size() > most;)
    if (blocks_[i].last_seen < limit) remove(i);
  while (blocks_.size() > most) remove(blocks_.size() - 1);
}

std::vector<Eigen::Vector3d> LidarMapLevel::means(int least_count) const {
  std::vector<Eigen::Vector3d> means;
  const std::map<std::array<std::int32_t, 3>, std::size_t> in_order(place_.begin(), place_.end());
  for (const auto& [key, place] : in_order)
    for (std::size_t i = 0; i < blocks_[place].cells.size(); ++i) {
      const Cell& cell = blocks_[place].cells[i];
      if (cell.count < least_count) continue;
      const auto k = static_cast<std::int32_t>(i);
      const Eigen::Vector3d corner((key[0] << kBlockShift) + (k & kBlockMask),
                                   (key[1] << kBlockShift) + (k >> kBlockShift & kBlockMask),
                                   (key[2] << kBlockShift) + (k >> 2 * kBlockShift));
      means.push_back(cell_m_ * corner + cell.mean.cast<double>());
    }
  return means;
}

LidarMap::LidarMap(const LidarMapOptions& options) : finest_(static_cast<std::size_t>(options.levels) - 1) {
  for (int level = options.levels; level-- > 0;) levels_.emplace_back(options, level);
  LidarMapOptions wide = options;
  wide.min_flatness = options.wide_flatness;
  for (int level = 0; level < options.wide_levels; ++level)
    levels_.emplace_back(wide, options.levels + level);
}

void LidarMap::add(const Eigen::Vector3d& p) {
  for (LidarMapLevel& level : levels_) level.add(p);
}

std::optional<MapPlane> LidarMap::plane_near(const Eigen::Vector3d& p, const PlaneLimits& limits) const {
  for (const LidarMapLevel& level : levels_)
    if (const auto plane = level.plane_near(p, limits)) return plane;
  return std::nullopt;
}

void LidarMap::trim(const Eigen::Vector3d& centre) {
  for (LidarMapLevel& level : levels_) level.trim(centre);
}

std::vector<Eigen::Vector3d> LidarMap::points() const {
  constexpr int kSeenAgain = 2;  // single points are noise, or what moved
  return levels_[finest_].means(kSeenAgain);
}

std::size_t LidarMap::blocks() const {
  std::size_t sum = 0;
  for (const LidarMapLevel& level : levels_) sum += level.blocks();
  return sum;
}

}  // namespace uniquadric
