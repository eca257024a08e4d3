#pragma once

#include <Eigen/Core>
#include <vector>

#include "estimator/window/long_window.h"

namespace uniquadric {

/// Sides on which a body stood, from the planes of its views: planes within kSameSideCosine of each other are
/// one side, which at least kLeastContactViews views have to show. In the body's frame.
std::vector<ContactSide> contact_sides(const std::vector<ShapeView>& views);

inline constexpr double kSameSideCosine = 0.966;  ///< ours: 15 degrees
inline constexpr int kLeastContactViews = 3;      ///< ours

}  // namespace uniquadric
