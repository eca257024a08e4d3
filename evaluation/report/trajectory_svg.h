#pragma once

#include <string>

#include "evaluation/trajectory_comparison.h"

namespace uniquadric {

/// One picture of a comparison, an SVG file's text: the paths seen from above, the aligned estimate coloured
/// by its first error; x, y, z over time; each error over time. For light and dark. `title` stands above it.
std::string trajectory_svg(const TrajectoryComparison& comparison, const std::string& title);

}  // namespace uniquadric
