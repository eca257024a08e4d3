#pragma once

#include <Eigen/Core>
#include <optional>

#include "core/geometry/camera.h"
#include "core/geometry/ellipsoid.h"

namespace uniquadric {

/// Intersection over union of two ellipses' areas, good to 1e-12.
double ellipse_iou(const Ellipse& a, const Ellipse& b);

/// ... of their rotated rectangles (RotBbox) by the Vatti clipper, as in the paper: corners are moved to the
/// joint centre and scaled towards 2^30 before they are rounded to integers (error about 1e-9).
double rotated_rectangle_iou(const Ellipse& a, const Ellipse& b);

/// ... of the axis-aligned boxes around them.
double axis_aligned_box_iou(const Ellipse& a, const Ellipse& b);

/// ... of their rotated rectangles clipped to the image, which reaches half a pixel beyond the outer pixel
/// centres. Nothing when both lie wholly outside.
std::optional<double> clipped_rectangle_iou(const Ellipse& a, const Ellipse& b, const Camera& camera);

/// Half sides of the axis-aligned box around an ellipse [px].
Eigen::Vector2d half_extents(const Ellipse& ellipse);

}  // namespace uniquadric
