#pragma once

#include <map>
#include <string>
#include <vector>

#include "evaluation/results/summary.h"

namespace uniquadric {

/// A system's errors of one object over those of the single-frame baseline: the paper's over the paper's, a
/// variant's median over the baseline's median on the same sequences.
struct PaperRatio {
  std::string scene, object;
  std::string system;                   ///< kPaperUniquadric or a variant
  std::string baseline;                 ///< what it is divided by
  int runs = 0, good = 0;               ///< as in SummaryRow; 0 of the paper
  std::map<std::string, double> ratio;  ///< by metric name
};

/// What stands above a table of ratios.
inline constexpr const char* kRatioNote =
    "A figure is a system's error divided by that of the single-frame baseline; ours are medians over seeds. "
    "The "
    "paper's "
    "sequences are not ours, so only ratios compare. Below 1 the system is better than its baseline.";

/// Ratios of the objects that the paper has, of the metrics that its table has: first the paper's UniQuadric,
/// then every variant but the baseline, `single_frame_obb` or `single_frame_lidar`. A later output
/// (VARIANT@final) is divided by the same output of the baseline where that has it, else by what the baseline
/// knew at each frame. Nothing of objects without a baseline; no ratio over a median of 0.
std::vector<PaperRatio> paper_ratios(const std::vector<SummaryRow>& summary);

}  // namespace uniquadric
