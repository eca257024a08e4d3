#include "evaluation/comparison/score_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <utility>

#include "core/base/error.h"
#include "core/base/text.h"
#include "evaluation/results/metrics.h"
#include "evaluation/results/results.h"
#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;
using Fields = std::vector<std::string_view>;

const char* const kHeader = "sequence,object,variant,seed,metric,value,better,status";
enum Column { kSequence, kObject, kVariant, kSeed, kMetric, kValue, kBetter, kStatus, kColumns };

constexpr double kMostValue = 1e100;  // ours: its square is a number still

// Where a line is, for messages.
struct Line {
  const fs::path& file;
  int number;
  template <typename... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> what, Args&&... args) const {
    throw InputError(file, number, fmt::format(what, std::forward<Args>(args)...));
  }
};

std::uint64_t parse_seed(const Line& line, std::string_view text) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), seed);
  if (error != std::errc{} || end != text.data() + text.size())
    line.fail("seed '{}' is no whole number", text);
  return seed;
}

ScoreKey parse_key(const Line& line, const Fields& fields) {
  const auto columns = split(kHeader, ',');
  for (const Column column : {kSequence, kObject, kVariant, kMetric})
    if (fields[column].empty()) line.fail("{} is empty", columns[column]);
  return {{std::string(fields[kVariant]), std::string(fields[kSequence]), parse_seed(line, fields[kSeed])},
          std::string(fields[kObject]),
          std::string(current_name(fields[kMetric]))};
}

bool parse_lower(const Line& line, std::string_view text) {
  if (text != "lower" && text != "higher") line.fail("better '{}' is neither lower nor higher", text);
  return text == "lower";
}

std::optional<double> parse_value(const Line& line, const Fields& fields, bool lower) {
  const std::string_view text = fields[kValue], status = fields[kStatus];
  if (status != "ok" && status != "failed") line.fail("status '{}' is neither ok nor failed", status);
  if (status == "failed" && !text.empty()) line.fail("value '{}' of a cell that failed", text);
  if (status == "failed") return std::nullopt;
  const auto value = parse_double(text);
  if (!value) line.fail("value '{}' is no finite number", text);
  if (std::abs(*value) > kMostValue) line.fail("value {} is beyond {}", text, kMostValue);
  if (lower && *value < 0) line.fail("value {} of an error is below 0", text);
  if (const Metric* const metric =
          metric_of_name(current_name(fields[kMetric])))  // others are another program's
    if (const auto why = impossible(*metric, *value)) line.fail("value of {}: {}", metric->name, *why);
  return value;
}

const char* name_of(bool lower) {
  return lower ? "lower" : "higher";
}

// Which lines say of a metric that lower is better, and which that higher is.
struct Directions {
  struct Side {
    int lines = 0, first = 0;
  } higher, lower;
};
using MetricDirections = std::map<std::string, Directions>;

// Of a metric of ours each line is judged by itself, of another by what most lines say.
void note_direction(const Line& line, const std::string& name, bool lower, MetricDirections& directions) {
  const Metric* const metric = metric_of_name(name);
  if (metric && metric->lower_is_better != lower)
    line.fail("better '{}' of {}, of which {} is better", name_of(lower), name, name_of(!lower));
  Directions::Side& side = lower ? directions[name].lower : directions[name].higher;
  if (side.lines++ == 0) side.first = line.number;
}

// Where as many lines say one as the other, the one that comes later is told.
void settle_directions(const MetricDirections& directions, ScoreTable& table) {
  for (const auto& [metric, d] : directions) {
    const auto rank = [](const Directions::Side& side) { return std::pair(side.lines, -side.first); };
    const bool lower = rank(d.lower) > rank(d.higher);
    const Directions::Side &most = lower ? d.lower : d.higher, &few = lower ? d.higher : d.lower;
    if (few.lines > 0)
      Line{table.file, few.first}.fail("better '{}' of {} differs from {} of its {} lines", name_of(!lower),
                                       metric, most.lines, most.lines + few.lines);
    table.lower_is_better.emplace(metric, lower);
  }
}

void add_line(const Line& line, const Fields& fields, ScoreTable& table, MetricDirections& directions) {
  if (fields.size() != kColumns)
    line.fail("expected {} columns ({}), found {}", int{kColumns}, kHeader, fields.size());
  const ScoreKey key = parse_key(line, fields);
  const bool lower = parse_lower(line, fields[kBetter]);
  note_direction(line, key.metric, lower, directions);
  if (!table.cells.emplace(key, parse_value(line, fields, lower)).second)
    line.fail("this sequence, object, variant, seed and metric stand twice");
}

void note_runs(ScoreTable& table) {
  std::set<RunKey> good, estimated;
  for (const auto& [key, value] : table.cells) {
    (value ? good : table.failed).insert(key.run);
    if (key.object == "camera" && key.metric.starts_with("ape_"))
      (value == 0.0 ? table.camera_given : estimated).insert(key.run);
  }
  for (const RunKey& run : good) table.failed.erase(run);
  for (const RunKey& run : estimated) table.camera_given.erase(run);
}

void require_known(const ScoreTable& table, const char* what, const std::string& name,
                   const std::set<std::string>& known) {
  if (!known.contains(name))
    throw InputError(table.file, fmt::format("has no {} '{}', but {}", what, name, fmt::join(known, ", ")));
}

void select(ScoreTable& table, const ScoreSelection& selection) {
  std::set<std::string> variants, metrics;
  for (const auto& [key, value] : table.cells) variants.insert(key.run.variant), metrics.insert(key.metric);
  for (const RunKey& run : table.not_run) variants.insert(run.variant);
  if (selection.variant) require_known(table, "variant", *selection.variant, variants);
  std::set<std::string> wanted;
  for (const std::string& name : selection.metrics)
    require_known(table, "metric", *wanted.emplace(current_name(name)).first, metrics);
  const auto is_other = [&](const RunKey& run) {
    return selection.variant && run.variant != *selection.variant;
  };
  for (auto* const runs : {&table.not_run, &table.failed, &table.camera_given})
    std::erase_if(*runs, is_other);
  std::erase_if(table.cells, [&](const auto& cell) {
    return is_other(cell.first.run) || (!wanted.empty() && !wanted.contains(cell.first.metric));
  });
}

}  // namespace

ScoreTable read_score_table(const fs::path& path, const ScoreSelection& selection) {
  ScoreTable table;
  table.file = fs::is_directory(path) ? path / "scores.csv" : path;
  if (fs::is_directory(path) && !fs::exists(table.file))
    throw InputError(path, "is no results folder: it has no scores.csv");
  bool header = true;
  MetricDirections directions;
  for_each_line(
      table.file,
      [&](int number, const Fields& fields) {
        const Line line{table.file, number};
        if (!std::exchange(header, false)) return add_line(line, fields, table, directions);
        if (fields != split(kHeader, ',')) line.fail("expected the header {}", kHeader);
      },
      ',');
  settle_directions(directions, table);
  if (fs::is_directory(path) && fs::exists(path / "cells.csv"))
    for (const Cell& cell : read_cells(path / "cells.csv"))
      if (cell.status == CellStatus::missing) table.not_run.insert({cell.variant, cell.scene, cell.seed});
  if (table.cells.empty() && table.not_run.empty())
    throw InputError(table.file, header ? "is empty, expected a header" : "has no scores");
  note_runs(table);
  select(table, selection);
  return table;
}

ScoreTable& ScoreTables::table_of(const std::string& variant, const fs::path& folder) {
  const auto [at, is_new] = places_.emplace(variant, tables_.size());
  if (is_new) tables_.emplace_back(variant, ScoreTable{folder / "scores.csv", {}, {}});
  return tables_[at->second].second;
}

void ScoreTables::add(const Results& results, std::span<const char* const> metrics) {
  for (const Cell& cell : results.cells) {
    if (!cell.output.empty()) continue;
    ScoreTable& table = table_of(cell.variant, results.folder);
    if (cell.status == CellStatus::missing) table.not_run.insert({cell.variant, cell.scene, cell.seed});
  }
  for (const Score& s : scores(results)) {
    if (!output_of(s.variant).empty()) continue;
    const std::string metric = s.metric->name;
    if (!metrics.empty() && std::ranges::find(metrics, metric) == metrics.end()) continue;
    ScoreTable& table = table_of(s.variant, results.folder);
    table.lower_is_better.emplace(metric, s.metric->lower_is_better);
    table.cells.emplace(ScoreKey{{s.variant, s.sequence, s.seed}, s.object, metric}, s.value);
  }
}

std::vector<std::pair<std::string, ScoreTable>> ScoreTables::take() {
  for (auto& [variant, table] : tables_) note_runs(table);
  return std::move(tables_);
}

}  // namespace uniquadric
