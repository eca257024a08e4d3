#include "evaluation/results/scores.h"

#include <fmt/format.h>

#include <algorithm>

namespace uniquadric {
namespace {

using Cells = std::vector<const Cell*>;

bool any_run_has(const Cells& cells, const std::string& subject, const Metric& metric,
                 const std::string& variant = "") {
  return std::any_of(cells.begin(), cells.end(), [&](const Cell* cell) {
    const auto* figures =
        variant.empty() || cell->variant == variant ? find_subject(*cell, subject) : nullptr;
    return figures && figures->value.contains(metric.name);
  });
}

std::optional<double> value_of(const Cell& cell, const std::string& subject, const Metric& metric) {
  const auto* figures = find_subject(cell, subject);
  if (!figures) return std::nullopt;
  const auto found = figures->value.find(metric.name);
  return found == figures->value.end() ? std::nullopt : std::optional(found->second);
}

void add_scene(const Results& results, const std::string& scene, std::vector<Score>& rows) {
  Cells cells;
  for (const Cell& cell : results.cells)
    if (cell.scene == scene) cells.push_back(&cell);
  std::vector<std::pair<std::string, const Metric*>> figures;
  for (const std::string& subject : subjects_of(results, scene))
    for (const Metric& metric : all_metrics())
      if (any_run_has(cells, subject, metric)) figures.emplace_back(subject, &metric);
  if (figures.empty()) figures.emplace_back("all", &find_metric("coverage"));
  for (const Cell* cell : cells)
    if (cell->status != CellStatus::missing)
      for (const auto& [subject, metric] : figures)
        if (!metric->by_variant || any_run_has(cells, subject, *metric, cell->variant))
          rows.push_back(
              {scene, subject, cell->variant, cell->seed, metric, value_of(*cell, subject, *metric)});
}

}  // namespace

std::vector<Score> scores(const Results& results) {
  std::vector<Score> rows;
  for (const std::string& scene : scenes_of(results)) add_scene(results, scene, rows);
  return rows;
}

std::string scores_csv(const std::vector<Score>& scores) {
  std::string text = "sequence,object,variant,seed,metric,value,better,status\n";
  for (const Score& s : scores)
    text += fmt::format("{},{},{},{},{},{},{},{}\n", s.sequence, s.object, s.variant, s.seed, s.metric->name,
                        s.value ? fmt::format("{}", *s.value) : "",
                        s.metric->lower_is_better ? "lower" : "higher", s.value ? "ok" : "failed");
  return text;
}

}  // namespace uniquadric
