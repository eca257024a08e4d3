#pragma once

#include <cstddef>
#include <ostream>
#include <set>
#include <string>
#include <vector>

#include "evaluation/comparison/variant_verdicts.h"
#include "evaluation/results/summary.h"

namespace uniquadric {

/// What a report says of a whole bench, and which of its scenes it shows.
struct Overview {
  std::size_t scenes = 0, objects = 0, runs = 0, failed = 0;  ///< of all; runs without later outputs
  std::set<std::string> shown;                                ///< scenes
  std::size_t judged = 0;                                     ///< scenes that the verdicts are of
  std::vector<VariantVerdict> verdicts;
  /// Over all objects, and over those of the scenes that a family drew where there are more than one. Empty
  /// where all scenes are shown: then the page makes them from the scenes' own.
  std::vector<SummaryRow> rows;

  bool shows_all() const { return shown.size() == scenes; }
};

inline constexpr const char* kShownNote =
    "Half of them are those in which objects are modelled worst or runs failed, the others are spread evenly "
    "from hard to easy. scores.csv has all.";

/// Which scenes the verdicts are of; empty where that is all of them.
std::string judged_note(const Overview& overview);

/// Reads a results folder scene by scene and writes scores.csv on the way. More scenes than make
/// `most_rows` rows of a summary are not shown: half of those that are are the hardest, with runs that
/// failed and with the lowest 3D IoU of their worst object, in the mean over variants; the others stand
/// evenly spaced in this order. Of more than `most_judged` runs the verdicts are of scenes evenly spaced in
/// the order of the results: the gate keeps all that it judges in memory. Throws as for_each_scene.
Overview overview_of(const std::filesystem::path& folder, std::size_t most_rows, std::size_t most_judged,
                     std::ostream& scores);

}  // namespace uniquadric
