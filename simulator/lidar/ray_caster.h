#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "simulator/scene/scene.h"

namespace uniquadric {

struct CasterOptions {
  /// Instruction set Embree uses: ranges differ by up to 5e-7 m between them, never between thread counts.
  /// ours: avx2, so that machines with and without AVX-512 make the same bytes
  std::string isa = "avx2";
  /// Poses a scan that a moving object's trajectory is cut into, between which it turns and moves uniformly:
  /// 2 is the paper's model (paper: Eq. 3). 0: as many as `motion_tolerance_m` takes, body by body.
  int motion_keys = 0;
  /// ours: of the motion between keys; what single precision errs by at 50 m
  double motion_tolerance_m = 3e-6;
};

/// Rays in, hits out, an array a component. Coordinates are relative to CasterScan's origin, axes of the
/// world.
struct RayBlock {
  static constexpr int kCapacity = 256;
  template <typename T>
  using Row = std::array<T, kCapacity>;

  int count = 0;
  alignas(32) Row<float> origin_x, origin_y, origin_z, x, y, z;
  alignas(32) Row<float> time;  ///< place in the scan, [0, 1]
  // Results:
  Row<float> distance;          ///< in lengths of the direction; negative: nothing was hit
  Row<float> incidence_cos;     ///< |cosine| of the angle between ray and normal
  Row<float> reflectivity;      ///< of the surface
  Row<std::uint16_t> instance;  ///< the object's id, 0 for the static world
};

/// How a motion is cut into keys, evenly over a scan, and what it is taken for between them.
struct MotionKeys {
  int count = 1;      ///< 1: at rest
  bool slerp = true;  ///< turning and moving uniformly; otherwise matrices are interpolated entry by entry
};

/// The bodies as Embree sees them at the times of one scan. Threads may cast at once.
class CasterScan {
 public:
  struct State;
  explicit CasterScan(std::unique_ptr<State> state);
  CasterScan(CasterScan&&) noexcept;
  ~CasterScan();
  /// Casts all rays of the block. Subnormal floats count as zero meanwhile.
  void cast(RayBlock& rays) const;
  /// What each object's motion was cut into, in the scene's order.
  std::vector<MotionKeys> motion_keys() const;

 private:
  std::unique_ptr<State> state_;
};

/// Meshes prepared for casting: the world as one static body, the objects as moving ones.
class RayCaster {
 public:
  /// `reflectivity`: of an object or part of the world by name, in place of its colour's luminance.
  RayCaster(const std::vector<Body>& world, const std::vector<Body>& objects,
            const CasterOptions& options = {},
            const std::vector<std::pair<std::string, double>>& reflectivity = {});
  RayCaster(RayCaster&&) noexcept;
  ~RayCaster();

  /// Places the bodies for rays of [start_ns, end_ns], relative to `origin` (world frame [m]).
  CasterScan open(const Eigen::Vector3d& origin, std::int64_t start_ns, std::int64_t end_ns) const;

 private:
  struct State;
  std::shared_ptr<const State> state_;
};

/// The cheaper way in which [start_ns, end_ns] of a motion is met within `tolerance_m` for points up to
/// `radius_m` from the body's origin; at most 129 keys (Embree's limit). Uniform motion between keys is
/// truer, but Embree takes some ten times as long to place it.
MotionKeys motion_keys_for(const Motion& motion, std::int64_t start_ns, std::int64_t end_ns, double radius_m,
                           double tolerance_m);

}  // namespace uniquadric
