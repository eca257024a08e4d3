#pragma once

#include <initializer_list>
#include <string>
#include <vector>

#include "evaluation/report/picture.h"
#include "evaluation/results/results.h"
#include "evaluation/results/summary.h"

namespace uniquadric {

/// A plot of the report as a file of its own.
struct NamedPicture {
  std::string name;  ///< of a file, without its ending
  Picture picture;
};

/// A file's name of several parts: objects of recordings may have any name.
std::string figure_name(std::initializer_list<std::string> parts);

/// Every plot of the report. Over time, SCENE_OBJECT_COLUMN: a column of frames.csv each, a line a variant
/// (what it knew at each frame, of its first good seed), the true semi-axes dashed. Then the variants side by
/// side (variant_figures.h), and SCENE_range_error: the LiDAR's range errors, a line a seed. Each has a name
/// of its own.
std::vector<NamedPicture> figures_of(const Results& results, const std::vector<SummaryRow>& summary);

}  // namespace uniquadric
