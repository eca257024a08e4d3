#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/window/long_window.h"

namespace uniquadric {

/// Sides on which a body stood, from the planes of its views: planes within kSameSideCosine of each other are
/// one side, which at least kLeastContactViews views have to show. In the body's frame.
std::vector<ContactSide> contact_sides(const std::vector<ShapeView>& views);

/// Without the planes that the body reaches through, by its surface's points (3 x n, body's frame [m]): what
/// hides a part of a body may look as if the body stood on it.
void drop_crossed(std::vector<ContactSide>& sides, const Eigen::Matrix3Xd& points);

inline constexpr double kSameSideCosine = 0.966;  ///< ours: 15 degrees
inline constexpr int kLeastContactViews = 3;      ///< ours

}  // namespace uniquadric
