#include "estimator/ego/lidar_map.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

namespace uniquadric {
namespace {

constexpr std::int32_t kBlockShift = 2, kBlockEdge = 4, kBlockMask = 3;  // cells along an edge
constexpr unsigned kRow = 15;                                            // a bit for each cell along an edge

int index_in_block(const std::array<std::int32_t, 3>& cell) {
  return (cell[0] & kBlockMask) | (cell[1] & kBlockMask) << kBlockShift |
         (cell[2] & kBlockMask) << 2 * kBlockShift;
}

std::array<std::int32_t, 3> block_of(const std::array<std::int32_t, 3>& cell) {
  return {cell[0] >> kBlockShift, cell[1] >> kBlockShift, cell[2] >> kBlockShift};
}

// Of the eight blocks that a window may reach into, which one holds a cell; counted from the first one's
// corner.
std::size_t block_in_window(std::int32_t x, std::int32_t y, std::int32_t z) {
  return static_cast<std::size_t>(x >> kBlockShift | (y >> kBlockShift) << 1 | (z >> kBlockShift) << 2);
}

// Whether the variance in every direction is surely above a limit, by Cholesky's pivots: most of what is no
// plane is told so without its eigenvalues. `C` is a lower triangle.
bool is_thicker(const Eigen::Matrix3d& C, double limit) {
  constexpr double kSurely = 1.001;  // near the limit the eigenvalues' own rounding is to tell
  limit *= kSurely;
  const double a = C(0, 0) - limit, b = C(1, 0) / a, c = C(2, 0) / a;
  const double d = C(1, 1) - limit - b * C(1, 0), e = C(2, 1) - b * C(2, 0);
  return a > 0 && d > 0 && C(2, 2) - limit - c * C(2, 0) - e * e / d > 0;
}

}  // namespace

// Left uninitialised, for most of it is not used.
struct LidarMapLevel::Neighbours {
  struct Near {
    Eigen::Vector3d place;  // of the mean, relative to the query
    const Cell* cell;
  };
  struct Distance {
    double square;
    int of;  // which of the cells
  };
  int count = 0;
  std::array<Near, 27> cells;
  std::array<Distance, 27> distances;
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

void LidarMapLevel::add(const Eigen::Vector3d& p, double elevation_rad) {
  const auto cell = cell_of(p);
  const auto [found, is_new] = place_.try_emplace(block_of(cell), blocks_.size());
  if (is_new) blocks_.emplace_back().key = found->first;
  Block& block = blocks_[found->second];
  block.last_seen = time_;
  const int index = index_in_block(cell);
  const std::uint64_t bit = std::uint64_t{1} << index;
  if (block.full & bit) return;
  if (!block.has(index)) {
    block.slot[index] = static_cast<std::uint8_t>(block.cells.size());
    block.seen |= bit;
    block.cells.emplace_back();
  }
  Cell& here = block.cells[block.slot[index]];
  const auto elevation = static_cast<float>(elevation_rad);
  here.lowest_rad = here.count > 0 ? std::min(here.lowest_rad, elevation) : elevation;
  here.highest_rad = here.count > 0 ? std::max(here.highest_rad, elevation) : elevation;
  if (++here.count >= options_.max_count) block.full |= bit;
  const Eigen::Vector3d corner = cell_m_ * Eigen::Vector3d(cell[0], cell[1], cell[2]);
  const Eigen::Vector3f q = (p - corner).cast<float>(), before = q - here.mean;
  here.mean += before / static_cast<float>(here.count);
  const Eigen::Vector3f after = q - here.mean;  // Welford's recurrence
  here.square.head<3>() += before.cwiseProduct(after);
  here.square.tail<3>() +=
      Eigen::Vector3f(before.x() * after.y(), before.x() * after.z(), before.y() * after.z());
}

// The 27 cells lie in at most eight blocks: the one of the lowest cell, and the next ones.
LidarMapLevel::Neighbours LidarMapLevel::neighbours_of(const Eigen::Vector3d& p) const {
  auto lowest = cell_of(p);
  for (std::int32_t& k : lowest) --k;
  const auto key = block_of(lowest);
  std::array<std::int32_t, 3> from{}, blocks_along{};
  for (std::size_t k = 0; k < 3; ++k) {
    from[k] = lowest[k] & kBlockMask;
    blocks_along[k] = 1 + ((from[k] + 2) >> kBlockShift);
  }
  static const Block nothing;
  std::array<const Block*, 8> blocks;
  blocks.fill(&nothing);
  for (std::int32_t z = 0; z < blocks_along[2]; ++z)
    for (std::int32_t y = 0; y < blocks_along[1]; ++y)
      for (std::int32_t x = 0; x < blocks_along[0]; ++x)
        if (const Block* block = find({key[0] + x, key[1] + y, key[2] + z}))
          blocks[x | y << 1 | z << 2] = block;
  unsigned seen = 0;  // a bit for each of the 27
  for (int row = 0; row < 9; ++row) {
    const std::int32_t y = from[1] + row % 3, z = from[2] + row / 3;
    const int first = index_in_block({0, y, z});
    const auto seen_in = [&](std::int32_t x) {
      return unsigned(blocks[block_in_window(x, y, z)]->seen >> first) & kRow;
    };
    seen |= ((seen_in(0) | seen_in(kBlockEdge) << kBlockEdge) >> from[0] & 7U) << 3 * row;
  }
  Neighbours result;
  for (; seen != 0; seen &= seen - 1) {
    const std::int32_t k = std::countr_zero(seen), x = from[0] + k % 3, y = from[1] + k / 3 % 3,
                       z = from[2] + k / 9;
    const Cell& cell = blocks[block_in_window(x, y, z)]->at(index_in_block({x, y, z}));
    __builtin_prefetch(&cell.count);  // and the spread beside it, which a plane's fit reads next
    const Eigen::Vector3d corner(lowest[0] - from[0] + x, lowest[1] - from[1] + y, lowest[2] - from[2] + z);
    const Eigen::Vector3d place = cell_m_ * corner + cell.mean.cast<double>() - p;
    result.cells[result.count] = {place, &cell};
    result.distances[result.count] = {place.squaredNorm(), result.count};
    ++result.count;
  }
  return result;
}

std::optional<MapPlane> LidarMapLevel::plane_near(const Eigen::Vector3d& p, const PlaneLimits& limits) const {
  Neighbours near = neighbours_of(p);
  if (near.count < options_.min_neighbours) return std::nullopt;
  const int n = std::min(near.count, options_.neighbours);
  if (n < near.count)
    std::nth_element(near.distances.begin(), near.distances.begin() + n, near.distances.begin() + near.count,
                     [](const auto& a, const auto& b) { return a.square < b.square; });
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();
  double points = 0;
  float lowest_rad = std::numeric_limits<float>::max(), highest_rad = std::numeric_limits<float>::lowest();
  for (int i = 0; i < n; ++i) {
    const auto& [q, cell] = near.cells[near.distances[i].of];
    lowest_rad = std::min(lowest_rad, cell->lowest_rad);
    highest_rad = std::max(highest_rad, cell->highest_rad);
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
  if (highest_rad - lowest_rad < limits.min_rise_rad) return std::nullopt;
  mean /= points;
  const Eigen::Matrix3d spread = square / points - mean * mean.transpose();  // its lower triangle
  const double most2 = limits.max_thickness_m * limits.max_thickness_m;
  if (is_thicker(spread, most2)) return std::nullopt;
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(spread);
  const double least = std::max(solver.eigenvalues()[0], 0.0), middle = solver.eigenvalues()[1];
  if (least > most2 || middle < options_.min_flatness * least ||
      middle <= limits.min_breadth_m * limits.min_breadth_m)
    return std::nullopt;
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  MapPlane plane{normal, -normal.dot(p + mean), std::sqrt(least / points), std::sqrt(least), n};
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
    for (std::int32_t k = 0; k < kBlockEdge * kBlockEdge * kBlockEdge; ++k) {
      const Block& block = blocks_[place];
      if (!block.has(k) || block.at(k).count < least_count) continue;
      const Eigen::Vector3d corner((key[0] << kBlockShift) + (k & kBlockMask),
                                   (key[1] << kBlockShift) + (k >> kBlockShift & kBlockMask),
                                   (key[2] << kBlockShift) + (k >> 2 * kBlockShift));
      means.push_back(cell_m_ * corner + block.at(k).mean.cast<double>());
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

void LidarMap::add(const Eigen::Vector3d& p, double elevation_rad) {
  for (LidarMapLevel& level : levels_) level.add(p, elevation_rad);
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
