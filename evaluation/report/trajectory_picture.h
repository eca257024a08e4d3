#pragma once

#include <string>

#include "evaluation/report/picture.h"
#include "evaluation/trajectory_comparison.h"

namespace uniquadric {

/// One picture of a comparison: the paths seen from above, the aligned estimate coloured by its first error;
/// x, y, z over time; each error over time. `title` stands above it.
Picture trajectory_picture(const TrajectoryComparison& comparison, const std::string& title);

}  // namespace uniquadric
