#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"
#include "core/geometry/superquadric.h"
#include "core/sequence/ply.h"

namespace cv {
class Mat;
}

namespace uniquadric {

/// What is taken away of a superellipsoid where depth saw through it. All numbers are ours.
struct CarvingOptions {
  bool enabled = false;
  int cells = 64;                      // along a cube of the body's box's volume
  int views = 60;                      // spread evenly over those of the body
  static constexpr double sigmas = 3;  // of depth: what lies so far before a measured point is free
  static constexpr int min_views = 2;  // that have to see a cell free,
  static constexpr double min_share =
      0.05;  // and that share of those that see it at all: flying pixels are rare
  static constexpr double least_free =
      0.12;  // of the superellipsoid: below it the body has no hollows but noise
};

/// Carves the free space out of one superellipsoid (Kutulakos and Seitz, "A theory of shape by space
/// carving", 2000; by depth instead of colour). `noise_per_range`: standard deviation of depth over depth.
class BodyCarving {
 public:
  BodyCarving(const Superellipsoid& body, double noise_per_range, const CarvingOptions& options);

  /// Depth along the optical axis [m], CV_32F, 0 where there is none; of the lens as it is.
  void add(const cv::Mat& depth_m, const Camera& camera, const Pose& camera_from_object);

  /// The body that is left as a closed mesh of its cells' sides, in the object's frame [m]; nothing where
  /// hardly anything is free. Points of `seen`, with outward normals, say where the surface is closer.
  std::optional<SurfaceFile> carved(const SurfaceFile& seen) const;

 private:
  struct Cell {
    std::array<int, 3> place;
    Eigen::Vector3d middle;
    std::uint16_t seen = 0, free = 0;
  };
  bool is_free(const Cell& cell) const;

  CarvingOptions options_;
  double noise_per_range_;
  std::array<int, 3> size_{};  // of the grid
  Eigen::Vector3d corner_, cell_m_;
  std::vector<Cell> cells_;  // inside the superellipsoid
  double range_sum_m_ = 0;
  int views_ = 0;
};

}  // namespace uniquadric
