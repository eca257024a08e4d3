#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "core/base/text.h"
#include "core/base/version.h"
#include "evaluation/report/page.h"
#include "evaluation/report/plots.h"
#include "evaluation/results/metrics.h"
#include "evaluation/results/paper_ratios.h"

namespace uniquadric {
namespace {
using nlohmann::json;

// Columns of frames.csv that are plotted.
std::vector<const char*> plotted_columns() {
  std::vector<const char*> columns;
  for (const Plot& plot : kPlots)
    for (const char* column : {plot.column, plot.truth})
      if (column) columns.push_back(column);
  return columns;
}

json plots_json() {
  json list = json::array();
  for (const Plot& plot : kPlots) {
    json item = {
        {"title", plot.title}, {"unit", plot.unit}, {"column", plot.column}, {"error", plot.is_error}};
    if (plot.truth) item["truth"] = plot.truth;
    if (plot.is_share) item["range"] = {0, 1};
    list.push_back(std::move(item));
  }
  return list;
}

constexpr int kFigureDigits = 6;  // ours: more than any table shows

json metrics_json() {
  json list = json::array();
  for (const Metric& metric : all_metrics())
    list.push_back({{"name", metric.name},
                    {"label", metric.label},
                    {"unit", metric.unit},
                    {"better", metric.lower_is_better ? "lower" : "higher"},
                    {"definition", metric.definition}});
  return list;
}

json figures_json(const PaperFigures& figures) {
  json values = json::object();
  for (const Metric& metric : all_metrics())
    if (const auto value = figures.of(metric.name)) values[metric.name] = *value;
  return values;
}

json paper_json(const PaperRow& row) {
  const auto system = [](const char* name, const PaperFigures& figures) {
    return json{{"name", name}, {"figures", figures_json(figures)}};
  };
  return {{"scene", row.scene},
          {"object", row.object},
          {"systems", {system(kPaperBaseline, row.baseline), system(kPaperUniquadric, row.uniquadric)}}};
}

json ratios_json(const std::vector<SummaryRow>& summary) {
  json list = json::array();
  for (const PaperRatio& r : paper_ratios(summary))
    list.push_back({{"scene", r.scene},
                    {"object", r.object},
                    {"system", r.system},
                    {"baseline", r.baseline},
                    {"paper", r.system == kPaperUniquadric},
                    {"runs", r.runs},
                    {"good", r.good},
                    {"ratio", r.ratio}});
  return list;
}

// Rounded to what is shown: the page stays small.
json rounded(const std::optional<double>& value, int digits) {
  return value ? json(*parse_double(fmt::format("{:.{}g}", *value, digits))) : json(nullptr);
}

// What a run alone says is the whole figure: page/data.js makes the rest.
json spread_json(const Spread& s, const PageOptions& options) {
  const int digits = options.series_digits;
  if (s.n == 1 && !s.best) return rounded(s.median, kFigureDigits);
  json values = json::array();
  for (const std::size_t i : evenly_spaced(s.values.size(), std::min(options.spread_values, s.values.size())))
    values.push_back(rounded(s.values[i], digits));
  return {{"median", rounded(s.median, kFigureDigits)},
          {"min", rounded(s.min, kFigureDigits)},
          {"max", rounded(s.max, kFigureDigits)},
          {"n", s.n},
          {"best", s.best},
          {"mean", rounded(s.mean, digits)},
          {"values", values},
          {"interval", rounded(s.interval, digits)}};
}

json row_json(const SummaryRow& row, const PageOptions& options) {
  json spread = json::object();
  for (const auto& [metric, s] : row.spread) spread[metric] = spread_json(s, options);
  return {{"scene", row.scene}, {"object", row.object}, {"variant", row.variant}, {"runs", row.runs},
          {"good", row.good},   {"given", row.given},   {"spread", spread}};
}

// Every so many of a list.
template <typename T>
std::vector<T> thinned(const std::vector<T>& values, std::size_t step) {
  std::vector<T> kept;
  for (std::size_t i = 0; i < values.size(); i += step) kept.push_back(values[i]);
  return kept;
}

// A list, or its one value where all are the same (true semi-axes).
json column_json(const std::vector<std::optional<double>>& all, std::size_t step, int digits) {
  const std::vector<std::optional<double>> values = thinned(all, step);
  const bool constant =
      std::all_of(values.begin(), values.end(), [&](const auto& v) { return v == values.front(); });
  json list = json::array();
  for (std::size_t i = 0; i < (constant ? std::min<std::size_t>(1, values.size()) : values.size()); ++i)
    list.push_back(rounded(values[i], digits));
  return list;
}

json series_json(const ObjectSeries& series, std::size_t step, int digits) {
  json columns = json::object();
  for (const char* name : plotted_columns())
    if (const auto found = series.columns.find(name); found != series.columns.end())
      columns[name] = column_json(found->second, step, digits);
  return {{"object", series.subject},
          {"frames", thinned(series.frames, step)},
          {"stamps_ns", thinned(series.stamps_ns, step)},
          {"columns", columns}};
}

const char* to_string(CellStatus status) {
  switch (status) {
    case CellStatus::ok:
      return "ok";
    case CellStatus::failed:
      return "failed";
    case CellStatus::missing:
      return "missing";
    case CellStatus::not_applicable:
      return "not applicable";
  }
  return "";
}

json sizes_json(const std::vector<SizeSteadiness>& sizes) {
  json list = json::array();
  for (const SizeSteadiness& size : sizes) {
    const Eigen::Vector3d size_m = 2 * size.semi_axes_m;
    list.push_back({{"id", size.id},
                    {"states", size.states},
                    {"size_m", {size_m.x(), size_m.y(), size_m.z()}},
                    {"spread", size.spread}});
  }
  return list;
}

// Of which runs the plots over time are, and of these every how many frames.
struct SeriesShare {
  std::set<const Cell*> cells;
  std::size_t step = 1;
};

constexpr std::size_t kLongestStep = 8;  // ours: a quarter of a second

std::size_t values_of(const Cell& cell) {
  std::size_t values = 0;
  if (cell.evaluation)
    for (const ObjectSeries& series : cell.evaluation->series)
      values += series.frames.size() * plotted_columns().size();
  return values;
}

SeriesShare series_share(const Results& results, std::size_t most_values) {
  std::size_t all = 0;
  for (const Cell& cell : results.cells) all += values_of(cell);
  SeriesShare share;
  share.step = std::clamp<std::size_t>((all + most_values - 1) / most_values, 1, kLongestStep);
  std::set<std::pair<std::string, std::string>> seen;
  std::size_t kept = 0;
  for (const Cell& cell : results.cells) {
    const bool first = seen.emplace(cell.scene, cell.variant).second;
    if (all > kLongestStep * most_values && (!first || kept > kLongestStep * most_values)) continue;
    kept += values_of(cell);
    share.cells.insert(&cell);
  }
  return share;
}

// What is empty is left out: a page of failed runs has tens of thousands.
json cell_json(const Cell& cell, const SeriesShare& share, int digits) {
  json made = {{"scene", cell.scene},
               {"variant", cell.variant},
               {"seed", cell.seed},
               {"status", to_string(cell.status)}};
  if (!cell.output.empty()) made["output"] = cell.output;
  if (!cell.message.empty()) made["message"] = cell.message;
  if (!cell.evaluation) return made;
  made["folder"] = cell.folder.generic_string();
  if (cell.evaluation->isolation == "none") made["not_isolated"] = true;
  for (const auto& [stage, ms] : cell.evaluation->stage_ms) made["stage_ms"][stage] = rounded(ms, digits);
  if (!cell.evaluation->sizes.empty()) made["sizes"] = sizes_json(cell.evaluation->sizes);
  if (share.cells.contains(&cell))
    for (const ObjectSeries& s : cell.evaluation->series)
      made["series"].push_back(series_json(s, share.step, digits));
  return made;
}

json change_json(const MetricChange& change, int digits) {
  return {{"metric", change.metric},
          {"subjects", change.subjects},
          {"a", rounded(change.a, digits)},
          {"b", rounded(change.b, digits)},
          {"loss", rounded(change.loss, digits)},
          {"pairs", change.pairs},
          {"p_worse", rounded(change.p_worse, digits)},
          {"p_better", rounded(change.p_better, digits)},
          {"verdict", to_string(change.verdict)}};
}

// Of the objects shown, with the counts of all.
json verdict_json(const VariantVerdict& verdict, const std::set<std::string>& shown, int digits) {
  json objects = json::array(), metrics = json::array(), counts = json::object();
  for (const ObjectChange& o : verdict.objects) {
    if (shown.contains(o.scene))
      objects.push_back({{"scene", o.scene}, {"object", o.object}, {"verdict", to_string(o.verdict)}});
    json& count = counts[to_string(o.verdict)];
    count = count.is_null() ? 1 : count.get<int>() + 1;
  }
  for (const MetricChange& change : verdict.metrics) metrics.push_back(change_json(change, digits));
  return {{"baseline", verdict.baseline},
          {"variant", verdict.variant},
          {"objects", objects},
          {"counts", counts},
          {"metrics", metrics}};
}

json optional_json(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

// The cells without an open end, by their middles.
json errors_json(const LidarRoutes& routes) {
  json list = json::array();
  for (const ErrorCell& cell : routes.errors)
    if (std::isfinite(cell.from_m) && std::isfinite(cell.to_m))
      list.push_back({rounded((cell.from_m + cell.to_m) / 2, 6), cell.beams});
  return list;
}

json lidar_json(const LidarRoutes& r) {
  return {{"scene", r.scene},
          {"seed", r.seed},
          {"scans", r.scans},
          {"matched", r.matched},
          {"lost", r.lost},
          {"extra", r.extra},
          {"beyond", r.beyond()},
          {"completeness", r.completeness()},
          {"mean_m", r.mean_m},
          {"rms_m", r.rms_m},
          {"median_abs_m", r.median_abs_m},
          {"p95_abs_m", r.p95_abs_m},
          {"octree_ms", optional_json(r.octree_ms)},
          {"embree_ms", optional_json(r.embree_ms)},
          {"speed_ratio", optional_json(r.speed_ratio())},
          {"errors", errors_json(r)}};
}

}  // namespace

std::string page_data(const Results& results, const std::vector<SummaryRow>& summary,
                      const Overview& overview, const PageOptions& options) {
  json rows = json::array(), paper = json::array(), cells = json::array(), lidar = json::array(),
       verdicts = json::array(), overall = json::array();
  for (const VariantVerdict& verdict : overview.verdicts)
    verdicts.push_back(verdict_json(verdict, overview.shown, options.series_digits));
  for (const SummaryRow& row : overview.rows) overall.push_back(row_json(row, options));
  for (const SummaryRow& row : summary) rows.push_back(row_json(row, options));
  for (const PaperRow& row : paper_rows()) paper.push_back(paper_json(row));
  const SeriesShare share = series_share(results, options.series_values);
  for (const Cell& cell : results.cells) cells.push_back(cell_json(cell, share, options.series_digits));
  for (const Cell& cell : results.not_applicable)
    cells.push_back(cell_json(cell, share, options.series_digits));
  for (const LidarRoutes& routes : results.lidar) lidar.push_back(lidar_json(routes));
  const json data = {{"name", results.name},
                     {"report_program", kProgram},
                     {"programs", programs_of(results)},
                     {"seeds", seeds_of(results)},
                     {"alignments", alignments_of(results)},
                     {"config", results.config},
                     {"command", results.command},
                     {"hardware", results.hardware},
                     {"program", results.program},
                     {"inputs", results.inputs},
                     {"metrics", metrics_json()},
                     {"plots", plots_json()},
                     {"summary_metrics", summary_metrics()},
                     {"summary", rows},
                     {"paper", paper},
                     {"ratios", ratios_json(summary)},
                     {"ratio_note", kRatioNote},
                     {"verdicts", verdicts},
                     {"overall", overall},
                     {"shown_note", kShownNote},
                     {"judged_note", judged_note(overview)},
                     {"counts",
                      {{"scenes", overview.scenes},
                       {"objects", overview.objects},
                       {"runs", overview.runs},
                       {"failed", overview.failed}}},
                     {"descriptions", results.descriptions},
                     {"lidar", lidar},
                     {"cells", cells}};
  return data.dump(-1, ' ', false, json::error_handler_t::replace);  // messages may hold any bytes
}

}  // namespace uniquadric
