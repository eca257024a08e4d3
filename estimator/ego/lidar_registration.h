#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "estimator/ego/lidar_filter.h"
#include "estimator/ego/lidar_map.h"
#include "estimator/ego/lidar_observability.h"
#include "estimator/ego/lidar_sweep.h"

namespace uniquadric {

/// All numbers are ours, chosen on subway_car.
struct LidarSightOptions {
  std::optional<double> range_sigma_m;           // of a point along its beam; else as its data sheet says
  std::optional<double> beam_sigma_rad;          // across it: jitter and the width of the beam; likewise
  static constexpr double plane_sigma_m = 0.01;  // of the map's planes, whose walls are not quite flat
  double max_thickness = 1.0;  // of a plane, over the noise of points at that range: thicker are two
  static constexpr double min_breadth =
      2;                  // of a plane, over the same noise: points of one ring of a spinning sensor are a
                          // line that noise makes broad, and the plane through them is no wall's
  double min_rise = 2.5;  // of a plane from its lowest beam to its highest, over the beams' noise, and half
                          // of the gap between a spinning sensor's rows: one row that goes in and out of a
                          // facade lies in a plane as well, which goes along with the sensor
  static constexpr double side_points =
      1000;                // that the points facing one way are worth at most: they share their
                           // planes' errors, and walls along a street must not outvote its cross-ways
  double gate_sigmas = 3;  // beyond what the prediction explains, a point is off its plane
  static constexpr double gate_m = 0.1;  // at least
  double open_gate_m = 0.5;              // at most: farther off is another surface
  double huber_sigmas = 1.5;
  int searches = 2;                               // iterations that look for planes anew
  static constexpr double search_again_m = 0.01;  // for points that have moved so far since
  int min_points = 30;                            // on planes; below, the sweep says nothing
  ObservabilityOptions observability;
};

/// Of a point along its beam, and across it a metre away.
struct PointSigmas {
  double range_m = 0, beam_rad = 0;
};
/// As the options say, else the sensor's; at least some millimetres, for no wall is flatter.
PointSigmas point_sigmas(const LidarSightOptions& options, const LidarDataSheet& sensor);

/// What becomes map: a point in the world, and its beam's elevation over the sensor's own level.
struct LidarMapPoint {
  Eigen::Vector3d world = Eigen::Vector3d::Zero();
  double elevation_rad = 0;
};

/// What became of a sweep.
struct SweepReport {
  std::int64_t end_ns = 0;
  int points = 0, on_planes = 0, on_bodies = 0;
  double rms_m = 0;  ///< of the points on planes
  /// Of the place after it, in the axes of the world of the start [m^2]. What the map itself is off by, which
  /// is the drift, is not in it.
  Eigen::Matrix3d place_covariance_m2 = Eigen::Matrix3d::Zero();
};

/// One sweep against the map: its points, one a voxel, and the planes they are put to.
class LidarRegistration {
 public:
  /// `prior` is the covariance at the sweep's end; map and path have to outlive this.
  LidarRegistration(const LidarMap& map, const std::vector<TimedPoint>& points, const SweepPath& path,
                    const Pose& body_from_lidar, double voxel_m, const Matrix18d& prior,
                    const PointSigmas& sigmas, double row_gap_rad, const LidarSightOptions& options);

  /// The sums of the points on planes, none where they are too few.
  LidarNormal normal_at(const LidarState& state, int iteration);
  /// All points in the world, but those whose voxel lies off the map's planes: they may be moving, and do not
  /// become map.
  std::vector<LidarMapPoint> map_points(const LidarState& end) const;
  int on_planes() const { return on_planes_; }
  double share_on_planes() const {
    return static_cast<double>(on_planes_) / std::max(1.0, static_cast<double>(sights_.size()));
  }
  double rms_m() const { return rms_m_; }

 private:
  struct Sight {
    SweepPoint point;
    double range_m = 0;
    Eigen::Vector3d beam_at_end = Eigen::Vector3d::Zero();  // unit, in the body's axes at the sweep's end
    std::optional<MapPlane> plane;
    Eigen::Vector3d sought_at = Eigen::Vector3d::Zero();
    bool is_off = false;
    double distance_m = 0, variance = 0;
    std::size_t side = 0;  // of sides_, that the plane faces
    Row12d jacobian = Row12d::Zero();
  };
  SweepPoint place(int point) const;
  double variance_of(const Sight& sight, const Eigen::Matrix3d& R) const;
  void look(Sight& sight, const LidarState& state, const Eigen::Matrix3d& R, int iteration) const;
  void add_noise(const Sight& sight, const LidarState& state, double weight, SightingSquare& noise) const;
  std::array<double, 3> shares();
  bool counts(const Sight& sight) const { return sight.plane && !sight.is_off; }
  std::size_t side_of(const MapPlane& plane) const;

  const LidarMap& map_;
  const std::vector<TimedPoint>& points_;
  const SweepPath& path_;
  Pose body_from_lidar_;
  Eigen::Matrix<double, 6, 6> prior_;
  PointSigmas sigmas_;
  double min_rise_rad_;
  LidarSightOptions options_;
  VoxelChoice choice_;
  std::vector<Sight> sights_;
  Eigen::Matrix3d sides_ = Eigen::Matrix3d::Identity();  // the main ways that planes face, in columns
  int on_planes_ = 0;
  double rms_m_ = 0;
};

}  // namespace uniquadric
