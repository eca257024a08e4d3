#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

namespace uniquadric {

/// Triangles of one material in their body's object frame [m], wound counter-clockwise seen from outside.
struct Mesh {
  std::vector<Eigen::Vector3f> positions;
  std::vector<Eigen::Vector3f> normals;  ///< unit, one a position
  std::vector<Eigen::Vector2f> uvs;      ///< one a position; (0, 0) is the texture's first pixel's corner
  std::vector<std::array<std::uint32_t, 3>> triangles;
  cv::Mat texture;  ///< CV_8UC3 (blue, green, red), repeats outside [0, 1]; empty: `color` alone
  Eigen::Vector3f color = Eigen::Vector3f::Ones();  ///< (red, green, blue) in [0, 1], multiplies the texture
  float shine = 0;                                  ///< in [0, 1]: white that the sun's mirror image adds
  float depth_return = 1;  ///< in [0, 1]: share of a depth sensor's light that comes back; 0: glass
};

}  // namespace uniquadric
