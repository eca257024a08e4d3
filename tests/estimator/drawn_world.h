#pragma once

#include <Eigen/Core>
#include <functional>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "core/geometry/camera.h"
#include "core/sequence/sequence.h"

namespace uniquadric {

/// A textured upright rectangle in front of a textured wall, at one depth.
struct Sprite {
  int id = 0;
  std::uint32_t texture = 0;  ///< same number, same colours
  cv::Vec3f color;            ///< around which the texture varies
  cv::Size size;
  double depth_m = 2;
  std::function<Eigen::Vector2d(std::int64_t frame)> corner_px;  ///< upper left, rounded to whole pixels
};

struct DrawnFrame {
  SequenceFrame frame;  ///< 30 Hz
  cv::Mat rgb, depth, masks;
};

/// The camera of drawn worlds.
Camera drawn_camera();

/// A world of sprites, the nearer in front of the farther, as a frame shows it: exact depth, and ids.
DrawnFrame draw_world(const std::vector<Sprite>& sprites, std::int64_t frame);

/// Overlap of two masks.
double mask_iou(const cv::Mat& a, const cv::Mat& b);

}  // namespace uniquadric
