#pragma once

#include <span>
#include <string>
#include <vector>

#include "evaluation/results/results.h"

namespace uniquadric {

/// 3D IoU of one (scene, object, variant) over the frames whose arc of views lies in [from_deg, to_deg), the
/// last interval with its end. Of each seed the mean over frames; of these over seeds:
struct ArcPoint {
  double from_deg = 0, to_deg = 0;
  double median = 0, min = 0, max = 0;
  int seeds = 0;  ///< that have such frames
};
struct ArcCurve {
  std::string scene, object, variant;
  std::vector<ArcPoint> points;  ///< in order; intervals without a frame are left out
};

/// Curves by scene, object and variant in the order of cells.csv, the intervals between the ascending
/// `edges_deg`. Evaluations without arcs have none.
std::vector<ArcCurve> arc_curves(const Results& results, std::span<const double> edges_deg);

/// A section of report.md, a column an interval; empty when there is nothing to show.
std::string arc_markdown(const Results& results);

/// The curves as one picture, a panel an object, for light and dark: a file's text. Empty when there is
/// nothing to show.
std::string arc_svg(const Results& results);
/// The same for a page: its style, the legend, and a picture a panel, as many side by side as have room.
std::string arc_html(const Results& results);

}  // namespace uniquadric
