#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/comparison/score_comparison.h"
#include "tests/evaluation/fabricated_scores.h"

namespace uniquadric {

inline ScoreTable table_of(const std::vector<FabricatedScore>& scores) {
  ScoreTable table{"scores.csv", {}, {}, {}};
  for (const FabricatedScore& s : scores) {
    table.lower_is_better[s.metric] = is_lower_better(s.metric);
    table.cells[{{s.variant, s.sequence, s.seed}, s.object, s.metric}] =
        s.failed ? std::nullopt : std::optional(s.value);
  }
  return table;
}

inline ScoreComparison compare(const std::vector<FabricatedScore>& a, const std::vector<FabricatedScore>& b,
                               const GateOptions& options = {}) {
  return compare_scores(table_of(a), table_of(b), options);
}

inline const MetricChange& find(const ScoreComparison& comparison, const std::string& metric) {
  return *std::find_if(comparison.metrics.begin(), comparison.metrics.end(),
                       [&](const MetricChange& change) { return change.metric == metric; });
}

/// One side in `trial`, with noise of its own.
inline std::vector<FabricatedScore> noisy(double noise, int trial) {
  return fabricated_scores(noise, static_cast<std::uint64_t>(100 + trial));
}

}  // namespace uniquadric
