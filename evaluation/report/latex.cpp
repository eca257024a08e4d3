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

// The last word, or the unit, below the rest: figures are narrow.
std::string head_of(const Metric& metric) {
  std::string above = metric.label, below = *metric.unit ? fmt::format("[{}]", metric.unit) : "";
  if (const auto space = above.rfind(' '); below.empty() && space != above.npos)
    below = above.substr(space + 1), above.resize(space);
  return fmt::format("\\shortstack[r]{{{}\\\\{{}}{}}}", latex_escaped(above), latex_escaped(below));
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

bool has_other_letters(const SummaryRow& row) {
  return std::ranges::any_of(row.scene + row.object + row.variant,
                             [](const char c) { return static_cast<unsigned char>(c) > '~'; });
}

}  // namespace

std::string latex_escaped(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '\\')
      result += "\\textbackslash{}";
    else if (c == '<' || c == '>' || c == '|')  // other glyphs in LaTeX's first font encoding
      result += c == '<' ? "\\textless{}" : c == '>' ? "\\textgreater{}" : "\\textbar{}";
    else if (c == '[')  // behind a row's end it would begin that one's argument
      result += "{[}";
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
  const bool is_whole = std::ranges::all_of(rows, [](const auto& row) { return row.good == row.runs; });
  std::vector<std::string> head = {""};
  if (!is_whole) head.emplace_back("runs");
  for (const Metric* metric : metrics) head.push_back(head_of(*metric));
  std::string text = fmt::format("% Medians over seeds, by {}. Needs \\usepackage{{booktabs}}.\n", kProgram);
  if (std::ranges::any_of(rows, has_other_letters))
    text += "% Names have letters that pdfLaTeX does not know: use LuaLaTeX with a font that has them.\n";
  text += "{\\footnotesize\\setlength{\\tabcolsep}{1.5pt}\n";
  text += fmt::format("\\begin{{tabular}}{{l{}}}\n  \\toprule\n", std::string(head.size() - 1, 'r'));
  text += row_of(head);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const bool same = i > 0 && rows[i].scene == rows[i - 1].scene && rows[i].object == rows[i - 1].object;
    if (!same)
      text += fmt::format("  \\midrule\n  \\multicolumn{{{}}}{{l}}{{\\textit{{{}}}, {}}} \\\\\n", head.size(),
                          latex_escaped(rows[i].object), latex_escaped(rows[i].scene));
    const std::string& variant = rows[i].variant;
    const bool is_below = same && without_output(rows[i - 1].variant) == without_output(variant);
    std::vector<std::string> cells = {is_below ? "\\quad " + latex_escaped(output_of(variant))
                                               : latex_escaped(variant)};
    if (!is_whole) cells.push_back(fmt::format("{}/{}", rows[i].good, rows[i].runs));
    for (const Metric* metric : metrics)
      cells.push_back(shown_figure(rows[i], metric->name, "--", {"\\textbf{", "}"}));
    text += row_of(cells);
  }
  return text + "  \\bottomrule\n\\end{tabular}}\n";
}

}  // namespace uniquadric
