#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/comparison/change.h"
#include "evaluation/comparison/pairing.h"
#include "evaluation/comparison/significance.h"

namespace uniquadric {

/// The gate's numbers (docs/compare.md). Margins are in ChangeRule.
struct GateOptions {
  // The two tests together have a false alarm in 4.25 % of comparisons at most: SPEC's 5 % with room to show
  // it.
  double alpha = 0.03;  ///< ours: of the means over all sequences, corrected by Holm
  /// ours: of single objects on single sequences, corrected for their number; 8 seeds of one reach 1 / 256
  double place_alpha = 0.0125;
  double suspect_p = 0.01;  ///< ours: an uncorrected p that is worth a look: of 20 metrics one in five times
  std::size_t place_seeds = 8;  ///< SPEC: for a claim on one sequence
  bool gate_time = false;       ///< computing time may fail the gate, too
};

/// In the order of the table.
enum class Verdict { worse, suspect, not_judged, better, no_proven_change };
/// Why a verdict is what it is, where the change and p of all sequences do not say it.
enum class VerdictReason { none, one_place, below_margin, not_proven, few_pairs, few_differ, time_only };

/// One object on one sequence.
struct PlaceChange {
  std::string sequence, object;
  double loss = 0;                         ///< mean over seeds, on the rule's scale; positive is worse
  std::map<std::uint64_t, double> losses;  ///< by seed, those that are paired
  std::optional<double> p;  ///< corrected for the number of places (place_test.h); of those that are tested
  bool worse = false;
};

/// One metric of one variant, of all objects, of the camera or of `all`.
struct MetricChange {
  std::string variant, metric;
  std::string subjects;  ///< objects, camera or all
  ChangeRule rule;
  /// mean over sequences of means over seeds of means over objects (geometric: ratio, unless all are too
  /// small to count)
  double a = 0, b = 0;
  double loss = 0;  ///< the same mean of the pairs' losses, on the rule's scale; positive is worse
  double noise =
      0;  ///< standard deviation of that mean when each pair's sign is a coin's; a loss of 3 is seen
  std::size_t sequences = 0, pairs = 0;     ///< pairs of (sequence, seed)
  std::vector<double> summands, weights;    ///< of the mean: weight * loss of each pair, and the weights
  SignFlip test;                            ///< uncorrected; above: a loss
  std::optional<double> p_worse, p_better;  ///< corrected by Holm; of metrics that are tested
  std::vector<PlaceChange> places;          ///< greatest loss first
  bool judged_by_mean = false;              ///< so many pairs can prove a loss of the mean (provable.h)
  bool judged_by_place = false;             ///< so many seeds of one sequence can prove a loss there
  std::optional<double> provable;           ///< the smallest loss of the mean that would be `worse`
  Verdict verdict = Verdict::no_proven_change;
  VerdictReason reason = VerdictReason::none;
};

enum class GateAnswer { pass, worse, undecided, incomplete };

struct ScoreComparison {
  std::string a, b;  ///< names of the sides
  GateOptions options;
  Pairing pairing;
  std::vector<MetricChange> metrics;  ///< worst first
  GateAnswer answer = GateAnswer::pass;
};

/// The paired gate: is B worse than A? `worse`: a metric is, or a cell failed that did not in A; else
/// `incomplete`: cells are missing, or there is no pair at all; else `undecided`: no metric has enough pairs
/// to prove a loss, and one shows a loss beyond its margin; else `pass`. The same for the same input,
/// whatever the order of its rows.
ScoreComparison compare_scores(const ScoreTable& a, const ScoreTable& b, const GateOptions& options = {});

std::size_t count_verdicts(const ScoreComparison& comparison, Verdict verdict);
const char* to_string(Verdict verdict);
const char* to_string(VerdictReason reason);  ///< a few words; empty for none
const char* to_string(GateAnswer answer);

/// As a short table for people, worst first; as the same in markdown, with all metrics folded away; and as
/// JSON: keys sorted, doubles that read back the same.
std::string comparison_text(const ScoreComparison& comparison);
std::string comparison_markdown(const ScoreComparison& comparison);
std::string comparison_json(const ScoreComparison& comparison);

/// As JUnit XML: a test case for the answer, which fails unless it is `pass`, and one for each metric, which
/// fails where it is worse and is skipped where it is not judged.
std::string comparison_junit(const ScoreComparison& comparison);

}  // namespace uniquadric
