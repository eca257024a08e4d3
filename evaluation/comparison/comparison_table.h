#pragma once

#include <string>
#include <vector>

#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {

/// What text and markdown share: cells of text, the head first.
using TableLines = std::vector<std::vector<std::string>>;

/// All metrics, or those alone of which there is something to tell; a column for the variant where there are
/// several.
TableLines change_table(const ScoreComparison& comparison, bool all);
/// Its columns' sides: '<' of words, '>' of numbers.
std::string sides_of(const ScoreComparison& comparison);

/// "worse: of 27 metrics 1 worse, 1 suspect, 2 better, 23 with no proven change; 1 new failure"
std::string headline(const ScoreComparison& comparison);
/// What was paired: sequences, seeds, figures.
std::string extent(const ScoreComparison& comparison);

/// "worse: A 0.0566, B 0.0623, +10 %, p 0.003": one metric in a line.
std::string describe_change(const MetricChange& change);

/// A list of gaps with its title, e.g. new failures.
struct GapList {
  std::string title;
  std::vector<std::string> lines;  ///< at most 12; the last says how many there are besides
};
/// Those that are not empty: not judged, metrics of A alone, what is new in B, new failures, missing in B,
/// missing in A, mended.
std::vector<GapList> gap_lists(const ScoreComparison& comparison);

}  // namespace uniquadric
