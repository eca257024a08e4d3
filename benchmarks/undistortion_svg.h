#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

namespace uniquadric {

/// A body's points in its own frame, by what was undone of the motion.
struct UndistortionPanel {
  std::string title, subtitle;
  std::vector<Eigen::Vector3d> points;
};

/// Panels beside each other, as an SVG: the points from above (x to the right, y up) and the hull of the
/// body's vertices seen so. What lies farther than `margin_m` off the body is not drawn.
std::string undistortion_svg(const std::vector<UndistortionPanel>& panels,
                             const std::vector<Eigen::Vector3d>& vertices, double margin_m = 1.2);

}  // namespace uniquadric
