#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <string>
#include <vector>

namespace uniquadric {

/// A pinhole camera with Brown-Conrady distortion (k1, k2, p1, p2, k3: OpenCV's order). Camera frame: x
/// right, y down, z forward. Pixel centres lie at integer coordinates.
struct Camera {
  int width = 640, height = 480;                      ///< [px]
  double fx = 525, fy = 525, cx = 319.5, cy = 239.5;  ///< [px]
  std::array<double, 5> distortion{};                 ///< k1 k2 p1 p2 k3

  bool has_distortion() const;
  Eigen::Matrix3d matrix() const;  ///< K
  /// Whether a pixel lies on the image, whose outline runs half a pixel outside the outer pixel centres.
  bool contains(const Eigen::Vector2d& pixel) const;
  /// Pixel of a point in the camera frame [m]; nothing for points with z <= 0.
  std::optional<Eigen::Vector2d> project(const Eigen::Vector3d& point) const;
  /// Ray (x, y, 1) through a pixel; the distortion is inverted by Newton's method, nothing where it has no
  /// inverse.
  std::optional<Eigen::Vector3d> unproject(const Eigen::Vector2d& pixel) const;
};

/// The same camera with an ideal lens: what sees the undistorted pixels.
Camera without_distortion(Camera camera);

/// What is hardly any camera's: a principal point outside the image, an angle of view across it below 2 or
/// above 170 degrees, a distortion without inverse at a corner.
std::vector<std::string> calibration_faults(const Camera& camera);

}  // namespace uniquadric
