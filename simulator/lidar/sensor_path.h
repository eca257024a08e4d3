#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "core/geometry/pose.h"

namespace uniquadric {

struct BeamBlock;

/// A pose as a function of time [s] from the sequence's start.
using PoseAt = std::function<Pose(double time_s)>;

/// Rays of a block of beams in the world's axes, relative to SensorPath::origin() [m].
struct WorldRays {
  static constexpr int kCapacity = 256;
  alignas(32) std::array<double, kCapacity> x, y, z;  ///< unit direction
  alignas(32) std::array<double, kCapacity> origin_x, origin_y, origin_z;
};

/// A sensor's trajectory through one scan, evaluated for every point: cubics through four poses each in
/// pieces of 5 ms (ours: evaluating a spline of poses for each point would cost more than casting its ray).
/// A motion of 1 m at 1 Hz is met within 1e-9 m, one of 1 mm at 50 Hz within 1e-5 m.
class SensorPath {
 public:
  /// For times in [start_ns, end_ns].
  SensorPath(const PoseAt& world_from_sensor, std::int64_t start_ns, std::int64_t end_ns);

  /// A point near the sensor's first position whose coordinates are multiples of 2^-10 m, and so exact in
  /// single precision up to 16 km: what is cast is cast relative to it.
  const Eigen::Vector3d& origin() const { return origin_; }

  /// Rays of beams whose times lie in the scan and do not decrease.
  void place(const BeamBlock& beams, WorldRays& rays) const;

 private:
  /// Factors of u^0 .. u^3 of each entry of world_from_sensor: the rotation by rows, then the translation
  /// relative to the origin; u in [0, 1].
  using Piece = std::array<std::array<double, 12>, 4>;
  void place_run(const Piece& piece, double piece_start_ns, int from, int to, const BeamBlock& beams,
                 WorldRays& rays) const;

  double start_ns_, piece_ns_;
  Eigen::Vector3d origin_;
  std::vector<Piece> pieces_;
};

}  // namespace uniquadric
