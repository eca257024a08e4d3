#include <fmt/format.h>
#include <fmt/ranges.h>

#include "core/base/version.h"
#include "evaluation/report/arc_curves.h"
#include "evaluation/report/page.h"
#include "evaluation/results/markup.h"
#include "evaluation/results/metrics.h"
#include "evaluation/results/paper_ratios.h"

namespace uniquadric {
namespace {

std::string line(const std::vector<std::string>& fields) {
  return fmt::format("| {} |\n", fmt::join(fields, " | "));
}

std::string paper_line(const SummaryRow& row, const char* system, const PaperFigures& figures) {
  std::vector<std::string> fields = {markdown_cell(row.scene), markdown_cell(row.object),
                                     fmt::format("*{}*", system), ""};
  for (const char* metric : summary_metrics()) {
    const auto value = figures.of(metric);
    fields.push_back(value ? fmt::format("*{:.3f}*", *value) : "");
  }
  return line(fields);
}

std::string table(const std::vector<SummaryRow>& summary) {
  std::vector<std::string> head = {"scene", "object", "variant", "runs"},
                           rule = {"---", "---", "---", "---:"};
  for (const char* name : summary_metrics()) {
    head.push_back(label_with_unit(find_metric(name)));
    rule.push_back("---:");
  }
  std::string text = line(head) + line(rule);
  for (std::size_t i = 0; i < summary.size(); ++i) {
    const SummaryRow& row = summary[i];
    if (row.object == "all" && row.good > 0) continue;  // tracking and time: in scores.csv and the page
    std::vector<std::string> fields = {markdown_cell(row.scene), markdown_cell(row.object),
                                       markdown_cell(row.variant), fmt::format("{}/{}", row.good, row.runs)};
    for (const char* metric : summary_metrics())
      fields.push_back(shown_figure(row, metric, "-", {"**", "**"}));
    text += line(fields);
    if (!row.paper || !ends_object(summary, i)) continue;
    text += paper_line(row, kPaperBaseline, row.paper->baseline);
    text += paper_line(row, kPaperUniquadric, row.paper->uniquadric);
  }
  return text;
}

std::string ratio_line(const PaperRatio& row, const std::vector<const Metric*>& metrics) {
  const bool paper = row.system == kPaperUniquadric;
  std::vector<std::string> fields = {markdown_cell(row.scene), markdown_cell(row.object),
                                     paper ? fmt::format("*{}*", row.system) : markdown_cell(row.system),
                                     markdown_cell(row.baseline),
                                     paper ? "" : fmt::format("{}/{}", row.good, row.runs)};
  for (const Metric* metric : metrics) {
    const auto found = row.ratio.find(metric->name);
    const std::string text = found == row.ratio.end() ? "-" : format_figure(found->second);
    fields.push_back(paper ? fmt::format("*{}*", text) : text);
  }
  return line(fields);
}

// Of objects that the paper has, where the results have the baseline.
std::string against_the_paper(const std::vector<SummaryRow>& summary) {
  const std::vector<PaperRatio> ratios = paper_ratios(summary);
  if (ratios.empty()) return "";
  const std::vector<const Metric*> metrics = paper_metrics();
  std::vector<std::string> head = {"scene", "object", "system", "divided by", "runs"},
                           rule = {"---", "---", "---", "---", "---:"};
  for (const Metric* metric : metrics) {
    head.push_back(metric->label);
    rule.push_back("---:");
  }
  std::string text =
      fmt::format("\n## Against the paper, as ratios\n{}\n\n", kRatioNote) + line(head) + line(rule);
  for (const PaperRatio& row : ratios) text += ratio_line(row, metrics);
  return text;
}

// Of scenes and recordings without a true object.
std::string sizes(const Results& results) {
  std::string text;
  for (const Cell& cell : results.cells)
    if (cell.evaluation)
      for (const SizeSteadiness& size : cell.evaluation->sizes) {
        const Eigen::Vector3d size_m = 2 * size.semi_axes_m;
        text += line({markdown_cell(cell.scene), markdown_cell(cell.variant), std::to_string(cell.seed),
                      std::to_string(size.id), std::to_string(size.states),
                      fmt::format("{:.3f} x {:.3f} x {:.3f}", size_m.x(), size_m.y(), size_m.z()),
                      format_figure(size.spread)});
      }
  if (text.empty()) return "";
  return "\n## Estimated objects where no true one is known\nSize: the median over time. Spread: the root "
         "mean "
         "square relative deviation from it.\n\n" +
         line({"scene", "variant", "seed", "id", "states", "size [m]", "spread"}) +
         line({"---", "---", "---:", "---:", "---:", "---", "---:"}) + text;
}

std::string failures(const Results& results) {
  std::string text;
  for (const Cell& cell : results.cells)
    if (cell.status != CellStatus::ok && cell.output.empty())
      text += line({markdown_cell(cell.scene), markdown_cell(cell.variant), std::to_string(cell.seed),
                    cell.status == CellStatus::failed ? markdown_cell(cell.message) : "not run"});
  if (text.empty()) return "";
  return "\n## Runs without a result\n" + line({"scene", "variant", "seed", "why"}) +
         line({"---", "---", "---:", "---"}) + text;
}

std::string not_applicable(const Results& results) {
  if (results.not_applicable.empty()) return "";
  std::string text = "\n## Not applicable\n" + line({"scene", "variant", "seed", "why"}) +
                     line({"---", "---", "---:", "---"});
  for (const Cell& cell : results.not_applicable)
    text += line({markdown_cell(cell.scene), markdown_cell(cell.variant), std::to_string(cell.seed),
                  markdown_cell(cell.message)});
  return text;
}

}  // namespace

std::string page_markdown(const Results& results, const std::vector<SummaryRow>& summary,
                          const Overview& overview) {
  std::string text = fmt::format(
      "# {}\nMedians over seeds; runs: with a result / all; the best of an object's variants with the most "
      "results in bold; given: poses of the camera that were not estimated.\n\n",
      markdown_cell(results.name));
  if (!overview.rows.empty())
    text += fmt::format("## Over all {} scenes\nMedians over objects.\n\n{}\n## {} scenes\n{}\n\n",
                        overview.scenes, table(overview.rows), overview.shown.size(), kShownNote);
  if (const std::string note = judged_note(overview); !note.empty()) text += note + "\n\n";
  text += table(summary) + against_the_paper(summary) + arc_markdown(results) +
          lidar_markdown(results.lidar) + sizes(results) + failures(results) + not_applicable(results) +
          "\n## How it was made\n";
  if (!results.command.empty()) text += fmt::format("- command: {}\n", markdown_cell(results.command));
  text += fmt::format("- program: {} (report: {})\n",
                      markdown_cell(fmt::format("{}", fmt::join(programs_of(results), ", "))), kProgram);
  if (!results.program.empty()) text += fmt::format("- gathered by: {}\n", markdown_cell(results.program));
  if (!results.inputs.empty())
    text += fmt::format("- inputs (hashes): {}\n",
                        markdown_cell(fmt::format("{}", fmt::join(results.inputs, ", "))));
  if (const auto alignments = alignments_of(results); !alignments.empty())
    text += fmt::format("- alignment of the estimates' worlds: {}\n", fmt::join(alignments, ", "));
  text += fmt::format("- seeds: {}\n", fmt::join(seeds_of(results), ", "));
  if (!results.hardware.empty()) text += fmt::format("- hardware: {}\n", markdown_cell(results.hardware));
  text += "\n## What the figures mean\n";
  for (const char* name : summary_metrics()) {
    const Metric& metric = find_metric(name);
    text += fmt::format("- **{}**{}: {}\n", metric.label,
                        *metric.unit ? fmt::format(" [{}]", metric.unit) : "", metric.definition);
  }
  return text +
         "\nThe paper: UniQuadric, arXiv 2309.17036, Table III; it prints no unit of rotation, taken as "
         "radians.\n";
}

}  // namespace uniquadric
