#include "evaluation/report/latex.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "core/base/version.h"

namespace uniquadric {
namespace {

std::string row_of(const std::vector<std::string>& cells) {
  return fmt::format("  {} \\\\\n", fmt::join(cells, " & "));
}

// Metrics that some row has.
std::vector<const Metric*> shown_metrics(const std::vector<SummaryRow>& rows) {
  std::vector<const Metric*> metrics;
  for (const char* name : summary_metrics())
    if (std::any_of(rows.begin(), rows.end(),
                    [&](const SummaryRow& row) { return row.spread.contains(name); }))
      metrics.push_back(&find_metric(name));
  return metrics;
}

}  // namespace

std::string latex_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\textbackslash{}";
    else if (c == '~' || c == '^')
      result += fmt::format("\\{}{{}}", c);
    else if (std::string_view("&%$#_{}").find(c) != std::string_view::npos)
      result += fmt::format("\\{}", c);
    else
      result += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return result;
}

std::string latex_table(const std::vector<SummaryRow>& summary) {
  std::vector<SummaryRow> rows;
  for (const SummaryRow& row : summary)
    if (row.object != "all" || row.good == 0) rows.push_back(row);
  const auto metrics = shown_metrics(rows);
  std::vector<std::string> head = {"scene", "object", "variant", "runs"};
  for (const Metric* metric : metrics)
    head.push_back(
        latex_escaped(*metric->unit ? fmt::format("{} [{}]", metric->label, metric->unit) : metric->label));
  std::string text = fmt::format("% Medians over seeds, by {}. Needs \\usepackage{{booktabs}}.\n", kProgram);
  text += fmt::format("\\begin{{tabular}}{{lllr{}}}\n  \\toprule\n", std::string(metrics.size(), 'r'));
  text += row_of(head) + "  \\midrule\n";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool same = i > 0 && rows[i].scene == rows[i - 1].scene && rows[i].object == rows[i - 1].object;
    if (i > 0 && !same) text += "  \\addlinespace\n";
    std::vector<std::string> cells = {
        same ? "" : latex_escaped(rows[i].scene), same ? "" : latex_escaped(rows[i].object),
        latex_escaped(rows[i].variant), fmt::format("{}/{}", rows[i].good, rows[i].runs)};
    for (const Metric* metric : metrics)
      cells.push_back(shown_figure(rows[i], metric->name, "--", {"\\textbf{", "}"}));
    text += row_of(cells);
  }
  return text + "  \\bottomrule\n\\end{tabular}\n";
}

}  // namespace uniquadric
