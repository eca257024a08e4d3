#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

namespace uniquadric {

/// All numbers are ours, chosen on subway_car.
struct LidarMapOptions {
  double cell_m = 0.25;  // of the finest means that are kept
  int levels = 2;        // of cells, each twice as large as the one before
  int wide_levels = 1;   // of larger cells still, for points that the others find no plane for: rings of a
                         // spinning sensor are farther apart than their cells
  static constexpr double wide_flatness = 15;  // min_flatness of the wide ones, which may span corners
  static constexpr int neighbours = 9;         // means a plane is fitted to, at most
  static constexpr int min_neighbours = 5;     // at least: FAST-LIO2's five
  double min_flatness = 5;  // middle eigenvalue over the least one: what is thinner is a line or a blob
  static constexpr int max_count =
      30;                    // points of a cell; later ones leave it as it is: a map does not follow drift
  double max_range_m = 150;  // of the sensor; what is farther is forgotten
  int max_blocks = 40'000;   // of 64 cells, 2.7 KB each at most, a level
};

/// normal . p + offset_m = 0
struct MapPlane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset_m = 0;
  double sigma_m = 0;      ///< of its place along the normal
  double thickness_m = 0;  ///< standard deviation of its points off it
  int cells = 0;           ///< whose means it is fitted to
  /// The normal's error, one standard deviation along each of the plane's two axes, in columns.
  Eigen::Matrix<double, 3, 2> normal_error = Eigen::Matrix<double, 3, 2>::Zero();
};

/// What a set of points has to be for a plane to be told by it.
struct PlaneLimits {
  double max_thickness_m = 0;  ///< standard deviation off the plane, at most
  double min_breadth_m = 0;    ///< standard deviation across the longer of its ways, more than
  double min_rise_rad = 0;     ///< from its lowest beam to its highest, at least
};

/// Cells of one size, of which each keeps the mean and spread of its points, in a hash of blocks of 4 x 4 x 4
/// cells. On a plane a mean lies on the plane, and is the truer the more often it was seen, which single
/// points are not.
class LidarMapLevel {
 public:
  LidarMapLevel(const LidarMapOptions& options, int level);

  /// `elevation_rad`: of the beam over the sensor's own level.
  void add(const Eigen::Vector3d& p, double elevation_rad = 0);
  /// The plane through the points of the cells whose means are nearest to p, of the 27 about it. Nothing
  /// where they are too few, not flat, or out of the limits.
  std::optional<MapPlane> plane_near(const Eigen::Vector3d& p, const PlaneLimits& limits) const;
  /// Forgets what is out of range of `centre`, and then what was seen least recently, down to max_blocks.
  void trim(const Eigen::Vector3d& centre);
  std::size_t blocks() const { return blocks_.size(); }
  /// Means of the cells with so many points, by their place.
  std::vector<Eigen::Vector3d> means(int least_count) const;

 private:
  struct Cell {
    Eigen::Vector3f mean = Eigen::Vector3f::Zero();                          // relative to the cell's corner
    Eigen::Matrix<float, 6, 1> square = Eigen::Matrix<float, 6, 1>::Zero();  // xx yy zz xy xz yz about it
    std::int32_t count = 0;
    float lowest_rad = 0, highest_rad = 0;  // elevations of its beams
  };
  struct Block {
    std::array<std::int32_t, 3> key{};
    std::uint64_t last_seen = 0;
    std::uint64_t seen = 0;               // a bit for each of the 64 cells that holds points
    std::uint64_t full = 0;               // and of those that take no more
    std::array<std::uint8_t, 64> slot{};  // of each of those in `cells`
    std::vector<Cell> cells;              // most of a block is empty

    bool has(int cell) const { return seen >> cell & 1; }
    const Cell& at(int cell) const { return cells[slot[static_cast<std::size_t>(cell)]]; }
  };
  struct KeyHash {
    std::size_t operator()(const std::array<std::int32_t, 3>& key) const;
  };
  struct Neighbours;
  std::array<std::int32_t, 3> cell_of(const Eigen::Vector3d& p) const;
  Neighbours neighbours_of(const Eigen::Vector3d& p) const;
  const Block* find(const std::array<std::int32_t, 3>& block) const;
  void remove(std::size_t block);

  LidarMapOptions options_;
  double cell_m_;
  std::unordered_map<std::array<std::int32_t, 3>, std::size_t, KeyHash> place_;  // of a block in blocks_
  std::vector<Block> blocks_;
  std::uint64_t time_ = 0;  // counts calls of trim()
};

/// An incremental map. A plane is sought from the coarsest level to the finest, the wide ones last: a wall is
/// one large plane, whose normal is known well; a window's reveal is a small one. (Normals of small pieces of
/// a wall err by some degrees, and many of them feign knowledge along the wall that there is none of.) Memory
/// is bounded: max_range_m, max_blocks.
class LidarMap {
 public:
  explicit LidarMap(const LidarMapOptions& options);
  /// As LidarMapLevel::add().
  void add(const Eigen::Vector3d& p, double elevation_rad = 0);
  std::optional<MapPlane> plane_near(const Eigen::Vector3d& p, const PlaneLimits& limits) const;
  void trim(const Eigen::Vector3d& centre);
  std::size_t blocks() const;
  /// Means of the finest cells that were seen more than once, in an order that the points alone decide.
  std::vector<Eigen::Vector3d> points() const;

 private:
  std::size_t finest_;
  std::vector<LidarMapLevel> levels_;  // coarsest first, the wide ones last
};

}  // namespace uniquadric
