#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

namespace uniquadric {

/// All numbers are ours, chosen on subway_car.
struct LidarClusterOptions {
  double cell_m = 1;                            // whose lowest point speaks for the ground there
  static constexpr double ground_tilt_deg = 6;  // of the ground at most
  static constexpr int ground_samples = 200;    // planes that are tried
  static constexpr double ground_m = 0.2;       // what is no higher above the ground is the ground
  double tolerance_m = 0.7;                     // between points of one body
  double max_rise_m = 2;  // between rows of a spinning LiDAR one above the other on it, at most
  int min_points = 10;    // of a body
  static constexpr double min_height_m =
      0.5;                   // kerbs and rails are lower; what hangs higher does not stand on the ground
  double max_extent_m = 24;  // along the ground: what is longer is a wall
};

/// The ground as height over a place: z = offset_m + slope . (x, y).
struct GroundPlane {
  Eigen::Vector2d slope = Eigen::Vector2d::Zero();
  double offset_m = 0;
  double height_of(const Eigen::Vector3d& point) const {
    return point.z() - offset_m - slope.dot(point.head<2>());
  }
};

/// The plane that most cells' lowest points lie on, of those that are nearly level (RANSAC; `seed` and `scan`
/// name its random numbers). Points (3 x n) in a world whose z is up. Nothing where fewer than three cells
/// have points or none agree.
std::optional<GroundPlane> find_ground(const Eigen::Matrix3Xd& points, const LidarClusterOptions& options,
                                       std::uint64_t seed, std::int64_t scan);

/// The angle from each point's row to the further one of the rows beside it [rad]; 0 where the points are in
/// no rows, as those of a rosette. `elevations_rad`: of the points over the sensor's own level.
std::vector<double> row_gaps(const std::vector<double>& elevations_rad);

/// The angle [rad] from beam to beam beside it: the median over points of one row, or of one level where
/// there are no rows.
double beam_step(const std::vector<double>& azimuths_rad, const std::vector<double>& elevations_rad);

/// How far apart a sensor's beams are at each point, of a surface that faces it [m].
struct BeamSpacing {
  std::vector<double> rises_m;                       ///< between rows; empty: there are none
  std::vector<double> steps_m;                       ///< from beam to beam along a row; empty: not known
  Eigen::Vector3d sensor = Eigen::Vector3d::Zero();  ///< in the points' frame
};

/// Points that hang together above the ground: their numbers, in increasing order; clusters in the order of
/// their first points. Too small, too low and too large ones are left out, and those that hang in the air.
/// Points hang together, too, over the distance of two rows one above the other, and along the line of sight
/// over that of two beams on a side which they meet under 10 degrees (after Borges and Aldon, "Line
/// extraction in 2D range images", 2004).
std::vector<std::vector<int>> clusters_above(const Eigen::Matrix3Xd& points,
                                             const std::optional<GroundPlane>& ground,
                                             const LidarClusterOptions& options,
                                             const BeamSpacing& spacing = {});

}  // namespace uniquadric
