#pragma once

#include <Eigen/Core>
#include <vector>

#include "core/geometry/camera.h"
#include "estimator/window/long_window.h"

namespace uniquadric {

/// Which points (3 x n, body's frame [m]) are beside the body: beyond a free tangent of the segmented
/// outlines by more than these are off by, in half of them and more. Masks that were carried take in what
/// a body uncovers.
std::vector<bool> beside_outlines(const Camera& camera, const std::vector<ShapeView>& views,
                                  const Eigen::Matrix3Xd& points);

/// Leaves those out of the points, and out of each view's own what is beside its own segmented outline.
void drop_beside_outlines(const Camera& camera, std::vector<ShapeView>& views, Eigen::Matrix3Xd& points);

}  // namespace uniquadric
