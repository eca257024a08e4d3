#pragma once

#include <string>
#include <vector>

#include "evaluation/results/summary.h"

namespace uniquadric {

/// The summary as a LaTeX table (booktabs) as wide as a page's text: a row a variant below its object, the
/// medians over seeds of the summary's metrics, the best bold. The number of runs where some have no result.
/// Names are escaped.
std::string latex_table(const std::vector<SummaryRow>& summary);

/// Text that LaTeX prints as it stands.
std::string latex_escaped(const std::string& text);

}  // namespace uniquadric
