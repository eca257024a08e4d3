#include "evaluation/results/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <optional>
#include <span>

#include "evaluation/results/markup.h"
#include "evaluation/statistics/statistics.h"

namespace uniquadric {
namespace {

Spread spread_of(const std::vector<double>& values) {
  const Statistics s = *statistics(values);
  return {s.median, s.min, s.max, static_cast<int>(s.n), false, s.mean, confidence_interval(values), values};
}

// Objects that were never met are listed too, with coverage 0 and without errors.
bool has_result(const SubjectFigures& figures) {
  if (figures.subject == "all") return true;
  const auto coverage = figures.value.find("coverage");
  return figures.value.contains("ape_translation_rmse_m") &&
         (coverage == figures.value.end() || coverage->second > 0);
}

SummaryRow summarize_row(const Results& results, const std::string& scene, const std::string& object,
                         const std::string& variant) {
  SummaryRow row{scene, object, variant, 0, 0, object == "camera", {}, paper_row(scene, object)};
  std::map<std::string, std::vector<double>> values;
  for (const Cell& cell : results.cells) {
    if (cell.scene != scene || cell.variant != variant) continue;
    ++row.runs;
    const SubjectFigures* figures = find_subject(cell, object);
    if (!figures) continue;
    row.good += has_result(*figures) ? 1 : 0;
    row.given = row.given && cell.evaluation->camera_given;
    for (const auto& [metric, value] : figures->value) values[metric].push_back(value);
  }
  for (const auto& [metric, list] : values) row.spread[metric] = spread_of(list);
  row.given = row.given && row.good > 0;
  return row;
}

// The spreads of a metric that compare: of the rows with the most results, those over the most runs.
std::vector<Spread*> comparable(const std::vector<SummaryRow*>& rows, const char* metric) {
  int good = 0, n = 0;
  std::vector<Spread*> spreads;
  for (const SummaryRow* row : rows)
    if (!row->given) good = std::max(good, row->good);
  for (SummaryRow* row : rows)
    if (const auto found = row->spread.find(metric);
        !row->given && row->good == good && found != row->spread.end())
      spreads.push_back(&found->second);
  for (const Spread* spread : spreads) n = std::max(n, spread->n);
  std::erase_if(spreads, [n](const Spread* spread) { return spread->n < n; });
  return spreads;
}

// Marks the best of rows of one scene, object and output.
void mark_best(const std::vector<SummaryRow*>& rows) {
  const auto less = [](const Spread* a, const Spread* b) { return a->median < b->median; };
  for (const Metric& metric : all_metrics()) {
    const std::vector<Spread*> spreads = comparable(rows, metric.name);
    if (spreads.empty()) continue;
    const auto [min, max] = std::minmax_element(spreads.begin(), spreads.end(), less);
    const double least = (*min)->median, greatest = (*max)->median;
    if (least == greatest) continue;
    for (Spread* spread : spreads)
      spread->best = spread->median == (metric.lower_is_better ? least : greatest);
  }
}

std::string text_cell(const SummaryRow& row, const char* metric) {
  const auto found = row.spread.find(metric);
  return found == row.spread.end() ? "-"
                                   : format_figure(found->second.median) + (found->second.best ? "*" : " ");
}

std::vector<std::string> paper_line(const SummaryRow& row, const char* system, const PaperFigures& figures) {
  std::vector<std::string> line = {row.scene, row.object, system, ""};
  for (const char* metric : summary_metrics()) {
    const auto value = figures.of(metric);
    line.push_back(value ? format_figure(*value) + " " : "");
  }
  return line;
}

}  // namespace

std::string_view without_output(std::string_view variant) {
  return variant.substr(0, variant.find(kOutputMark));
}

std::string output_of(const std::string& variant) {
  return variant.substr(without_output(variant).size());
}

bool shows_given(const SummaryRow& row, const Metric& metric) {
  return row.given && metric.lower_is_better;
}

std::string shown_figure(const SummaryRow& row, const char* metric, const char* none,
                         const std::array<const char*, 2>& marks) {
  const auto found = row.spread.find(metric);
  if (found == row.spread.end()) return none;
  if (shows_given(row, find_metric(metric))) return "given";
  const std::string text = format_figure(found->second.median);
  return found->second.best ? marks[0] + text + marks[1] : text;
}

bool ends_object(const std::vector<SummaryRow>& rows, std::size_t i) {
  return i + 1 == rows.size() || rows[i + 1].object != rows[i].object || rows[i + 1].scene != rows[i].scene;
}

double median(const std::vector<double>& values) {
  assert(!values.empty());
  return statistics(values)->median;
}

std::optional<double> confidence_interval(const std::vector<double>& values) {
  if (values.size() < 2) return std::nullopt;
  const auto freedom = static_cast<double>(values.size() - 1);
  const double t = boost::math::quantile(boost::math::students_t(freedom), 0.975);
  return t * statistics(values)->std / std::sqrt(freedom);
}

std::string format_figure(double value) {
  const double size = std::abs(value);
  if (size == 0) return "0";
  if (size < 1e-4 || size >= 1e6) return fmt::format("{:.2e}", value);
  if (size >= 1000) return fmt::format("{:.0f}", value);
  return fmt::format("{:.{}f}", value,
                     size >= 100     ? 1
                     : size >= 10    ? 2
                     : size >= 0.1   ? 3
                     : size >= 0.001 ? 4
                                     : 5);
}

std::vector<SummaryRow> summarize(const Results& results) {
  std::vector<SummaryRow> rows;
  for (const std::string& scene : scenes_of(results)) {
    std::vector<std::string> subjects = subjects_of(results, scene);
    if (subjects.empty()) subjects.push_back("all");
    for (const std::string& subject : subjects) {
      const auto first = rows.size();
      for (const std::string& variant : variants_of(results, scene))
        rows.push_back(summarize_row(results, scene, subject, variant));
      std::map<std::string, std::vector<SummaryRow*>> by_output;
      for (SummaryRow& row : std::span(rows).subspan(first))
        by_output[output_of(row.variant)].push_back(&row);
      for (const auto& [output, of_output] : by_output) mark_best(of_output);
    }
  }
  return rows;
}

void OverallRows::add(const std::vector<SummaryRow>& summary) {
  for (const SummaryRow& row : summary) {
    if (!is_object(row.object)) continue;
    auto of = std::ranges::find(variants_, row.variant, &OfVariant::variant);
    if (of == variants_.end()) of = variants_.insert(of, {row.variant, 0, 0, 0, {}});
    ++of->objects, of->runs += row.runs, of->good += row.good;
    for (const auto& [metric, spread] : row.spread) of->medians[metric].push_back(spread.median);
  }
}

std::vector<SummaryRow> OverallRows::rows(const std::string& scene) const {
  std::vector<SummaryRow> rows;
  for (const OfVariant& of : variants_) {
    SummaryRow row{scene, fmt::format("{} objects", of.objects), of.variant, of.runs, of.good, false, {}, {}};
    for (const auto& [metric, medians] : of.medians) {
      Spread& spread = row.spread[metric] = spread_of(medians);
      spread.interval.reset();
      spread.values.clear();
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

std::string evaluation_text(const CellEvaluation& evaluation) {
  std::vector<std::vector<std::string>> lines = {{"object"}};
  for (const char* metric : summary_metrics()) lines[0].push_back(find_metric(metric).label);
  double false_bodies = 0;
  for (const SubjectFigures& figures : evaluation.subjects) {
    const auto figure = [&](const char* metric) -> std::optional<double> {
      const auto found = figures.value.find(metric);
      return found == figures.value.end() ? std::nullopt : std::optional<double>(found->second);
    };
    if (figures.subject == "all") {
      false_bodies = figure("false_bodies").value_or(0);
      continue;
    }
    lines.push_back({figures.subject});
    for (const char* metric : summary_metrics()) {
      const auto found = figure(metric);
      lines.back().push_back(found ? format_figure(*found) : "-");
    }
  }
  const std::string more = false_bodies > 0 ? fmt::format("false bodies: {}\n", false_bodies) : "";
  return aligned_columns(lines, "<") + more + "APE.t, RPE.t in m, APE.r, RPE.r in rad, root mean squares\n";
}

std::string summary_text(const std::vector<SummaryRow>& rows) {
  std::vector<std::vector<std::string>> lines = {{"scene", "object", "variant", "runs"}};
  for (const char* metric : summary_metrics())
    lines[0].push_back(std::string(find_metric(metric).label) + " ");
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const SummaryRow& row = rows[i];
    if (row.object == "camera" || (row.object == "all" && row.good > 0)) continue;
    lines.push_back({row.scene, row.object, row.variant, fmt::format("{}/{}", row.good, row.runs)});
    for (const char* metric : summary_metrics()) lines.back().push_back(text_cell(row, metric));
    if (!row.paper || !ends_object(rows, i)) continue;
    lines.push_back(paper_line(row, kPaperBaseline, row.paper->baseline));
    lines.push_back(paper_line(row, kPaperUniquadric, row.paper->uniquadric));
  }
  return aligned_columns(lines, "<<<") +
         "medians over seeds; as known at each frame, @fixed_lag: a lag later, @final: offline smoothing; "
         "APE.t, RPE.t in m, APE.r, RPE.r in rad, root mean squares;\n"
         "* best of its object's variants with the most runs;\n"
         "paper: Table III of arXiv 2309.17036, on the paper's own sequences\n";
}

}  // namespace uniquadric
