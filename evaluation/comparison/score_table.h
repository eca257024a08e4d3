#pragma once

#include <compare>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "evaluation/results/scores.h"

namespace uniquadric {

/// One run of a bench, and whether it has figures, is in the table below.
struct RunKey {
  std::string variant, sequence;
  std::uint64_t seed = 0;
  auto operator<=>(const RunKey&) const = default;
};

/// Which figure: a cell of scores.csv.
struct ScoreKey {
  RunKey run;
  std::string object, metric;
  auto operator<=>(const ScoreKey&) const = default;
};

/// One side of a comparison.
struct ScoreTable {
  std::filesystem::path file;                       ///< for messages
  std::map<ScoreKey, std::optional<double>> cells;  ///< no value: failed
  std::map<std::string, bool> lower_is_better;      ///< by metric
  std::set<RunKey> not_run{};                       ///< that cells.csv says are missing
  // Of all rows, whichever are selected:
  std::set<RunKey> failed{};        ///< runs whose rows all failed
  std::set<RunKey> camera_given{};  ///< runs of whose camera every APE is exactly 0: it is no estimate
};

/// What of a table to compare.
struct ScoreSelection {
  std::optional<std::string> variant;  ///< this one alone; default: all
  std::vector<std::string> metrics;    ///< these alone; default: all
};

/// Reads scores.csv, or that of a results folder of `bench`, with the runs that its cells.csv calls missing.
/// Throws InputError with file and line: header, number of columns, an empty name, a seed or value that is no
/// number, a value beyond 1e100, an error below 0, `better` that is neither lower nor higher, or
/// not what it is of that metric of ours or on most lines of another's, a `status` that is neither ok nor
/// failed or does not fit the value, a cell that stands twice; no rows; a variant or metric of the selection
/// that is not there.
ScoreTable read_score_table(const std::filesystem::path& path, const ScoreSelection& selection = {});

/// The same of results in memory, one table a variant, in the order of their cells; later outputs are left
/// out. `file` is the folder's scores.csv, which need not be there.
class ScoreTables {
 public:
  /// Adds the cells of some scenes. `metrics`: these alone; default: all.
  void add(const Results& results, std::span<const char* const> metrics = {});
  std::vector<std::pair<std::string, ScoreTable>> take();

 private:
  ScoreTable& table_of(const std::string& variant, const std::filesystem::path& folder);
  std::vector<std::pair<std::string, ScoreTable>> tables_;
  std::map<std::string, std::size_t> places_;  // of the variants
};

}  // namespace uniquadric
