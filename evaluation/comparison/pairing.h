#pragma once

#include <string>
#include <vector>

#include "evaluation/comparison/score_table.h"

namespace uniquadric {

/// A figure that both sides have.
struct PairedScore {
  ScoreKey key;
  double a = 0, b = 0;
};

/// Figures of one object in one run that one side lacks.
struct Gap {
  RunKey run;
  std::string object;                ///< empty: the whole run, which has no figure at all
  std::vector<std::string> metrics;  ///< in order of their names; empty for the whole run
  auto operator<=>(const Gap&) const = default;
};

/// Two tables set against each other. Every figure of either is in one of the lists.
struct Pairing {
  std::vector<PairedScore> pairs;               ///< in order of their keys
  std::vector<Gap> new_failures;                ///< ok in A, failed in B
  std::vector<Gap> mended;                      ///< failed in A, ok in B
  std::vector<Gap> missing_in_a, missing_in_b;  ///< in the other side alone, or not run
  std::size_t failed_in_both = 0;               ///< cells
  std::size_t camera_given = 0;                 ///< cells: errors of a camera whose poses one side was given
  std::size_t measured_on_one_side = 0;         ///< cells of computing time or memory
  std::size_t new_in_b = 0;                     ///< cells of what is new (below)
  /// that the other side, which has others, knows nowhere; in order of their names
  std::vector<std::string> metrics_of_a_alone, metrics_of_b_alone;
  std::vector<std::string> scenes_of_b_alone, variants_of_b_alone;  ///< the same
};

/// Pairs cells by (sequence, object, variant, seed, metric); variants go by their own names, so name them
/// alike before. A run all of whose rows failed fails in what it has no row for, too. Errors of a camera
/// whose poses one side was given are no pairs, and none is missing; nor is computing time or memory that one
/// side has alone, nor a metric, scene or variant that A knows nowhere: it is new. Throws InputError when a
/// metric is better in another direction in B.
Pairing pair_scores(const ScoreTable& a, const ScoreTable& b);

/// Leaves these metrics out of both tables. Throws InputError for one that neither has.
void ignore_metrics(ScoreTable& a, ScoreTable& b, const std::vector<std::string>& metrics);

/// Leaves out metrics that are others over some of their frames (Metric::is_part): they gain and lose with
/// these, and each costs the other metrics of the comparison some of their power.
void leave_out_parts(ScoreTable& table);

/// Every run's variant as `name`.
void rename_variant(ScoreTable& table, const std::string& name);

}  // namespace uniquadric
