#pragma once

#include <opencv2/core/mat.hpp>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// A camera's image, scaled, to draw on in the camera's pixels.
struct Canvas {
  cv::Mat image;  ///< CV_8UC3
  Camera camera;
  double scale = 1;  ///< of the image against the camera's

  /// Where a camera's pixel lies: outer borders of pixels map to outer borders.
  cv::Point2d at(const Eigen::Vector2d& pixel) const;
};

/// The image scaled to a width [px].
Canvas make_canvas(const cv::Mat& image, const Camera& camera, int width_px);

/// Tints the pixels of each id (CV_16UC1 of the camera's size, 0: none) in the id's colour, its border
/// stronger.
void tint_masks(Canvas& canvas, const cv::Mat& masks);

/// Draws a closed polygon of the rectified image, or the rotated rectangle of an ellipse there, where the
/// lens puts it.
void draw_polygon(Canvas& canvas, const std::vector<Eigen::Vector2d>& corners, const cv::Scalar& color,
                  int line_px);
void draw_rectangle(Canvas& canvas, const Ellipse& ellipse, const cv::Scalar& color, int line_px);

/// Draws the twelve edges of a box, semi-axes half its sides [m], where the lens puts them; what lies less
/// than 5 cm before the camera is left out.
void draw_box(Canvas& canvas, const Pose& camera_from_object, const Eigen::Vector3d& semi_axes_m,
              const cv::Scalar& color, int line_px);

/// Text centred on a point of the canvas, moved inside where it would stick out.
void draw_label(Canvas& canvas, const std::string& text, cv::Point2d at, const cv::Scalar& color);

}  // namespace uniquadric
