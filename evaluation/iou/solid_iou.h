#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "evaluation/iou/shifted_sequence.h"
#include "evaluation/iou/solid.h"

namespace uniquadric {

/// Points spread evenly over a solid: randomly shifted low-discrepancy points in its box, those outside left
/// out. Keep one for many pairs: making it costs more than using it.
class SolidSamples {
 public:
  static constexpr int kReplicates = uniquadric::kReplicates;
  /// `candidates` in the solid's box is rounded up to a multiple of kReplicates. The same seed gives the same
  /// points.
  SolidSamples(Solid solid, int candidates, std::uint64_t seed);
  const Solid& solid() const { return solid_; }
  /// The points of a replicate, in the solid's frame [m].
  std::span<const Eigen::Vector3d> points(std::size_t replicate) const;
  /// The solid's volume as a replicate has it, in closed form where there is one [m^3].
  double volume(std::size_t replicate) const { return volumes_[replicate]; }
  /// Mean of the replicates' [m^3]; 0 of a mesh that encloses nothing.
  double volume() const;
  /// What a single point stands for [m^3].
  double volume_of_point() const { return volume_of_point_; }

 private:
  Solid solid_;
  std::vector<Eigen::Vector3d> points_;
  std::array<std::size_t, kReplicates + 1> begins_{};
  std::array<double, kReplicates> volumes_{};
  double volume_of_point_ = 0;
};

/// The IoU of one pair.
struct SolidIou {
  double iou = 0;
  /// What each replicate by itself would say, to first order; all alike where the IoU is exact.
  std::array<double, SolidSamples::kReplicates> replicates{};
  double of_point = 0;  ///< by how much a single point changes it; 0 where it is exact
};

/// Intersection over union of the samples' solid and a superellipsoid. Exact for two boxes, two ellipsoids
/// and equal bodies, else sampled. Asserts that the solid has a volume.
SolidIou solid_iou(const SolidSamples& samples, const Superellipsoid& other, const Pose& samples_from_other);

/// The same with what a mesh encloses, of a volume that is known beforehand [m^3]; one below what both have
/// in common counts as that.
SolidIou solid_iou(const SolidSamples& samples, const MeshSolid& other, double other_volume,
                   const Pose& samples_from_other);

struct MeanIou {
  double mean = 0;
  /// From the spread over the replicates of each one's mean: pairs that share their points have no
  /// independent errors. With Student's t and two samples beside those seen as MonteCarloIou has it.
  double standard_error = 0;
};

/// Of pairs with the same samples; asserts that there is one.
MeanIou mean_iou(std::span<const SolidIou> pairs);

}  // namespace uniquadric
