#pragma once

#include <Eigen/Core>
#include <array>
#include <map>
#include <opencv2/core/types.hpp>
#include <optional>
#include <utility>
#include <vector>

#include "estimator/shape/lidar_clusters.h"

namespace uniquadric {

/// Where a point is in the sensor's own view: azimuth and elevation [rad].
using Bearing = cv::Point2f;

/// The points of one scan, in its order.
struct ScanPoints {
  Eigen::Matrix3Xd world;         ///< where the sensor saw them [m]
  std::vector<double> ago_s;      ///< before the scan's end
  std::vector<Bearing> bearings;  ///< in the sensor's frame then
  std::vector<float> ranges_m;
  std::vector<double> rises_m, steps_m;  ///< as in BeamSpacing
};

inline constexpr int kNoCluster = -1;

/// The nearest of what stands on the ground, in coarse cells of the sensor's view.
class NearestRange {
 public:
  /// `cluster_of`: the cluster of each point, or kNoCluster. What is no higher than `ground_m` is the ground.
  NearestRange(const ScanPoints& points, const std::optional<GroundPlane>& ground, double ground_m,
               const std::vector<int>& cluster_of, double cell_rad);

  /// In the cells beside a bearing, of what is not of a cluster [m]: its own near side hides nothing of a
  /// body that is not hidden from everywhere. What is below hides no side: it may be a kerb or the ground
  /// itself. 1e9 where there is nothing.
  float around(const Bearing& bearing, int but) const;

 private:
  static constexpr float kFar = 1e9;  // [m]
  struct Entry {
    float range_m = kFar;
    int cluster = kNoCluster;
  };
  struct Cell {
    std::array<Entry, 2> two;  // the nearest, and the nearest of another cluster
    void add(const Entry& entry);
  };
  std::pair<int, int> cell_of(const Bearing& bearing) const;

  double cell_rad_;
  int around_;  // cells
  std::map<std::pair<int, int>, Cell> cells_;
};

/// Where the sensor looks, by what it has seen so far: a hull of bearings, which goes on where it is closed.
class SensorView {
 public:
  void widen(const std::vector<Bearing>& bearings);
  bool is_at_rim(const Bearing& bearing, double rim_rad) const;

 private:
  std::vector<Bearing> hull_;
  bool is_closed_ = false;
};

}  // namespace uniquadric
