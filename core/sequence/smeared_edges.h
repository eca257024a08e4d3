#pragma once

#include <opencv2/core/mat.hpp>
#include <vector>

namespace uniquadric {

/// Adds the widths [px] of the ramps that a depth camera makes of steps between two surfaces: 1 where a step
/// is sharp. `depth` CV_32FC1 [m], 0 none. They are read off rows and columns: lines of inverse depth through
/// both sides disagree there by more than noise, and the ramp is what lies between them.
void add_edge_widths(const cv::Mat& depth, std::vector<double>& widths_px);

/// Their lower quartile: a narrow face between two others looks like a ramp too, but where a camera smooths
/// nearly all steps are ramps. 1 where there are too few steps.
double usual_edge_width_px(std::vector<double> widths_px);

/// Takes out the depth (CV_32FC1 [m]) of ramps of that width: where depth changes much more from one end of
/// the ramp to the other than beside it. What is left is depth of one surface each. Sharp edges, of a width
/// below 2 px, are left as they are.
void drop_smeared_edges(cv::Mat& depth, double width_px);

}  // namespace uniquadric
