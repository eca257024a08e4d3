#pragma once

#include <array>

namespace uniquadric {

/// A plot over time of one object: a column of frames.csv, and the one that holds the truth.
struct Plot {
  const char *title, *unit, *column, *truth = nullptr;
  bool is_share = false;  ///< from 0 to 1
  bool is_error = false;  ///< may be drawn on a log scale
};

/// Of the page (page/charts.js) and of figures/.
inline constexpr std::array kPlots = {
    Plot{"APE translation", "m", "ape_translation_m", nullptr, false, true},
    Plot{"APE rotation", "rad", "ape_rotation_rad", nullptr, false, true},
    Plot{"IoU solid", "", "iou3d_solid", nullptr, true},
    Plot{"IoU ellipsoid", "", "iou3d", nullptr, true},
    Plot{"2D IoU, rotated rectangles", "", "iou2d", nullptr, true},
    Plot{"Semi-axis x", "m", "est_semi_axis_x_m", "true_semi_axis_x_m"},
    Plot{"Semi-axis y", "m", "est_semi_axis_y_m", "true_semi_axis_y_m"},
    Plot{"Semi-axis z", "m", "est_semi_axis_z_m", "true_semi_axis_z_m"},
    Plot{"RPE translation", "m", "rpe_translation_m", nullptr, false, true},
    Plot{"RPE rotation", "rad", "rpe_rotation_rad", nullptr, false, true},
    Plot{"Share of the silhouette that is seen", "", "visible_fraction", nullptr, true}};

}  // namespace uniquadric
