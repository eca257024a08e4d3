#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/pose.h"

namespace uniquadric {

/// A flat textured rectangle: x, y in its plane, z = 0.
struct DrawnCard {
  int label = 0;  ///< 0 background
  Eigen::Vector2d size_m = Eigen::Vector2d::Ones();
  cv::Mat texture;  ///< CV_32FC1, over the whole card
  Pose camera_from_card;
};

/// A texture of random blocks at several scales, in grey levels.
cv::Mat block_texture(int side_px, std::uint64_t seed);

/// The faces of a box of one label, its frame at the centre; outward z.
std::vector<DrawnCard> box_cards(int label, const Eigen::Vector3d& size_m, std::uint64_t seed);

/// The cards moved by camera_from_body, where their poses were body_from_card.
std::vector<DrawnCard> moved(std::vector<DrawnCard> cards, const Pose& camera_from_body);

struct DrawnFrame {
  cv::Mat gray;        ///< CV_8UC1
  cv::Mat depth;       ///< CV_32FC1 [m]
  cv::Mat true_depth;  ///< without noise
  cv::Mat masks;       ///< CV_16UC1
};

struct DrawnNoise {
  double depth = 0;        ///< share of the depth, each pixel by itself
  double gray_levels = 0;  ///< of the image
};

/// Ray casting in closed form, without lens distortion; four samples a pixel for the grey level.
DrawnFrame draw(const Camera& camera, const std::vector<DrawnCard>& cards, const DrawnNoise& noise = {},
                std::uint64_t frame = 0);

/// A small camera for quick tests.
Camera small_camera();

}  // namespace uniquadric
