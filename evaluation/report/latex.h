#pragma once

#include <string>
#include <vector>

#include "evaluation/results/summary.h"

namespace uniquadric {

/// The summary as a LaTeX table (booktabs): a row an object and variant, the medians over seeds of the
/// summary's metrics, the best bold, a rule between objects. Names are escaped.
std::string latex_table(const std::vector<SummaryRow>& summary);

/// Text that LaTeX prints as it stands.
std::string latex_escaped(const std::string& text);

}  // namespace uniquadric
