#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "estimator/images/plane_depth.h"

namespace uniquadric {

/// 256 bits of what a piece of surface looks like straight from the front, at one metric scale.
struct SurfaceDescriptor {
  int scale = 0;  ///< a pixel of the view is 2^scale mm: descriptors of one scale can be compared
  std::array<std::uint64_t, 4> bits{};
};
int hamming_distance(const SurfaceDescriptor& a, const SurfaceDescriptor& b);

/// Least distance over the scales that both have; 257 where there is none.
int descriptor_distance(const std::vector<SurfaceDescriptor>& a, const std::vector<SurfaceDescriptor>& b);

/// A point of the image and the surface it lies on.
struct SurfacePoint {
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();  ///< raw image
  PlaneDepth surface;
};

/// Towards the camera, unit length, camera frame. `undistorted`: the point's pixel without distortion.
Eigen::Vector3d surface_normal(const Camera& camera, const Eigen::Vector2d& undistorted,
                               const PlaneDepth& surface);

/// The ORB descriptors (Rublee et al., ICCV 2011) of each point's surface, seen straight from the front so
/// that turning and approaching change little, at the two scales next to that of the image. None for surfaces
/// seen at more than 70 degrees and for points near the image's border.
std::vector<std::vector<SurfaceDescriptor>> describe_surfaces(const cv::Mat& gray, const Camera& lens,
                                                              const std::vector<SurfacePoint>& points);

}  // namespace uniquadric
