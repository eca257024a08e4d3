#pragma once

#include <vector>

#include "evaluation/report/figures.h"
#include "evaluation/results/summary.h"

namespace uniquadric {

/// The variants of every object side by side, a figure a metric of the summary: the runs' figures, their mean
/// and its 95 % confidence interval. Rows without the metric and given cameras are left out, and what is left
/// with a single row. Errors that span more than a factor of 20 are drawn by their logarithm. Names are
/// SCENE_OBJECT_METRIC_variants.
std::vector<NamedPicture> variant_figures(const Results& results, const std::vector<SummaryRow>& summary);

}  // namespace uniquadric
