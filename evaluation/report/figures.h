#pragma once

#include <string>
#include <vector>

#include "evaluation/report/picture.h"
#include "evaluation/results/results.h"

namespace uniquadric {

/// A plot of the report as a file of its own.
struct Figure {
  std::string name;  ///< of a file, without its ending: SCENE_OBJECT_COLUMN
  Picture picture;
};

/// The plots over time of every object: a column of frames.csv each, a line a variant (what it knew at each
/// frame, of its first good seed), the true semi-axes dashed.
std::vector<Figure> figures_of(const Results& results);

}  // namespace uniquadric
