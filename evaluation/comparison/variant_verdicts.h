#pragma once

#include <string>
#include <utility>
#include <vector>

#include "evaluation/comparison/score_comparison.h"
#include "evaluation/comparison/score_table.h"
#include "evaluation/results/results.h"

namespace uniquadric {

enum class ObjectVerdict { better, worse, mixed, alike, lost, mended };
const char* to_string(ObjectVerdict verdict);

/// What a variant is to its baseline on one object of one scene.
struct ObjectChange {
  std::string scene, object;
  ObjectVerdict verdict = ObjectVerdict::alike;
};

/// One variant of a bench against another that is taken as the baseline.
struct VariantVerdict {
  std::string baseline, variant;
  std::vector<ObjectChange> objects;  ///< in the order of the results
  std::vector<MetricChange> metrics;  ///< the gate's, of the summary's metrics (summary_metrics)
};

/// The gate (compare_scores) between variants of the same results, each with what it knew at each frame.
class VariantVerdicts {
 public:
  /// Adds some scenes of the results.
  void add(const Results& results);
  /// Of all that was added, once. Up to `most` variants every one is a baseline of every other, of more the
  /// first alone. On an object the variant is `lost` where runs fail that the baseline has, `mended` where it
  /// has runs that the baseline fails. Else its 3D IoU (of the solid, where both have it), APE.t and coverage
  /// decide, each as the mean over seeds: `better` where one gains more than the gate's margin for one place
  /// and none loses as much, `worse` the other way round, `mixed` where there are both, `alike` where there
  /// is neither. This is no proof: that is `metrics`.
  std::vector<VariantVerdict> verdicts(std::size_t most = 6);

 private:
  ScoreTables tables_;
  std::vector<std::pair<std::string, std::string>> objects_;  // scene and object
};

/// The same of results that are in memory.
std::vector<VariantVerdict> variant_verdicts(const Results& results, std::size_t most = 6);

}  // namespace uniquadric
