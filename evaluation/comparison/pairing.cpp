#include "evaluation/comparison/pairing.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <set>

#include "core/base/error.h"
#include "evaluation/comparison/change.h"
#include "evaluation/results/metrics.h"

namespace uniquadric {
namespace {

enum class Presence { ok, failed, absent };

// What a table knows: metrics, sequences and variants, of runs that were not tried too.
struct Known {
  std::set<std::string> metrics, scenes, variants;
  explicit Known(const ScoreTable& table) {
    for (const auto& [key, value] : table.cells) metrics.insert(key.metric), add(key.run);
    for (const RunKey& run : table.not_run) add(run);
  }
  // Of a table without any cell nobody can say what is new.
  bool lacks(const ScoreKey& key) const {
    return !metrics.empty() && !(metrics.contains(key.metric) && scenes.contains(key.run.sequence) &&
                                 variants.contains(key.run.variant));
  }

 private:
  void add(const RunKey& run) { scenes.insert(run.sequence), variants.insert(run.variant); }
};

// A table, and which of its runs have a figure.
struct Side {
  const ScoreTable& table;
  std::map<RunKey, bool> has_figure;  // of runs that have rows

  Known known;

  explicit Side(const ScoreTable& t) : table(t), known(t) {
    for (const auto& [key, value] : t.cells) has_figure[key.run] |= value.has_value();
    for (const RunKey& run : t.failed) has_figure.try_emplace(run, false);
  }
  bool failed_whole(const RunKey& run) const {
    const auto found = has_figure.find(run);
    return found != has_figure.end() && !found->second;
  }
  bool is_error(const std::string& metric) const {
    const auto found = table.lower_is_better.find(metric);
    return found != table.lower_is_better.end() && found->second;
  }
  Presence presence(const ScoreKey& key) const {
    const auto found = table.cells.find(key);
    if (found != table.cells.end()) return found->second ? Presence::ok : Presence::failed;
    return failed_whole(key.run) ? Presence::failed : Presence::absent;
  }
};

// Gathers cells to gaps; whole runs as one.
class Gaps {
 public:
  void add(const ScoreKey& key, bool whole_run) {
    if (whole_run) return add_run(key.run);
    metrics_[{key.run, key.object}].push_back(key.metric);
  }
  void add_run(const RunKey& run) { metrics_[{run, ""}]; }
  std::vector<Gap> list() const {
    std::vector<Gap> gaps;
    for (const auto& [place, metrics] : metrics_) gaps.push_back({place.first, place.second, metrics});
    return gaps;
  }

 private:
  std::map<std::pair<RunKey, std::string>, std::vector<std::string>> metrics_;
};

struct GapLists {
  Gaps new_failures, mended, missing_in_a, missing_in_b;
};

bool is_of_given_camera(const ScoreKey& key, const Side& a, const Side& b) {
  return key.object == "camera" && (a.is_error(key.metric) || b.is_error(key.metric)) &&
         (a.table.camera_given.contains(key.run) || b.table.camera_given.contains(key.run));
}

void add_cell(const ScoreKey& key, const Side& a, const Side& b, GapLists& gaps, Pairing& pairing) {
  if (is_of_given_camera(key, a, b)) {
    ++pairing.camera_given;
    return;
  }
  if (a.known.lacks(key)) {
    ++pairing.new_in_b;
    return;
  }
  const Presence in_a = a.presence(key), in_b = b.presence(key);
  if (is_measured(key.metric) && (in_a != Presence::ok || in_b != Presence::ok)) {
    pairing.measured_on_one_side += in_a == Presence::ok || in_b == Presence::ok;
    return;
  }
  const bool no_run_in_a = !a.has_figure.contains(key.run), no_run_in_b = !b.has_figure.contains(key.run);
  if (in_a == Presence::ok && in_b == Presence::ok)
    pairing.pairs.push_back({key, *a.table.cells.at(key), *b.table.cells.at(key)});
  else if (in_a == Presence::ok && in_b == Presence::failed)
    gaps.new_failures.add(key, b.failed_whole(key.run));
  else if (in_a == Presence::failed && in_b == Presence::ok)
    gaps.mended.add(key, a.failed_whole(key.run));
  else if (in_a == Presence::ok || no_run_in_b)
    gaps.missing_in_b.add(key, no_run_in_b);
  else if (in_b == Presence::ok || no_run_in_a)
    gaps.missing_in_a.add(key, no_run_in_a);
  else  // nobody has a figure: no pair is lost; a row may stand for a failed run alone
    pairing.failed_in_both += in_a == in_b;
}

void require_same_directions(const ScoreTable& a, const ScoreTable& b) {
  for (const auto& [metric, lower] : a.lower_is_better) {
    const auto found = b.lower_is_better.find(metric);
    if (found != b.lower_is_better.end() && found->second != lower)
      throw InputError(b.file, fmt::format("{} is better {}, in {} {}", metric, lower ? "higher" : "lower",
                                           a.file.string(), lower ? "lower" : "higher"));
  }
}

std::vector<std::string> without(const std::set<std::string>& names, const std::set<std::string>& others) {
  std::vector<std::string> rest;
  if (!others.empty())
    std::set_difference(names.begin(), names.end(), others.begin(), others.end(), std::back_inserter(rest));
  return rest;
}

}  // namespace

Pairing pair_scores(const ScoreTable& a, const ScoreTable& b) {
  require_same_directions(a, b);
  const Side side_a(a), side_b(b);
  Pairing pairing;
  GapLists gaps;
  for (const auto& [key, value] : a.cells) add_cell(key, side_a, side_b, gaps, pairing);
  for (const auto& [key, value] : b.cells)
    if (!a.cells.contains(key)) add_cell(key, side_a, side_b, gaps, pairing);
  for (const RunKey& run : a.not_run) gaps.missing_in_a.add_run(run);
  for (const RunKey& run : b.not_run) gaps.missing_in_b.add_run(run);
  std::sort(pairing.pairs.begin(), pairing.pairs.end(),
            [](const PairedScore& x, const PairedScore& y) { return x.key < y.key; });
  pairing.new_failures = gaps.new_failures.list();
  pairing.mended = gaps.mended.list();
  pairing.missing_in_a = gaps.missing_in_a.list();
  pairing.missing_in_b = gaps.missing_in_b.list();
  const Known &of_a = side_a.known, &of_b = side_b.known;
  pairing.metrics_of_a_alone = without(of_a.metrics, of_b.metrics);
  pairing.metrics_of_b_alone = without(of_b.metrics, of_a.metrics);
  if (a.cells.empty()) return pairing;
  pairing.scenes_of_b_alone = without(of_b.scenes, of_a.scenes);
  pairing.variants_of_b_alone = without(of_b.variants, of_a.variants);
  return pairing;
}

void ignore_metrics(ScoreTable& a, ScoreTable& b, const std::vector<std::string>& metrics) {
  const std::set<std::string> of_a = Known(a).metrics, of_b = Known(b).metrics;
  for (const std::string& name : metrics) {
    const std::string metric(current_name(name));
    if (!of_a.contains(metric) && !of_b.contains(metric))
      throw InputError(fmt::format("--ignore {}: neither {} nor {} has this metric", name, a.file.string(),
                                   b.file.string()));
    for (ScoreTable* const table : {&a, &b})
      std::erase_if(table->cells, [&](const auto& cell) { return cell.first.metric == metric; });
  }
}

void leave_out_parts(ScoreTable& table) {
  std::erase_if(table.cells, [](const auto& cell) {
    const Metric* const metric = metric_of_name(cell.first.metric);
    return metric && metric->is_part;
  });
}

void rename_variant(ScoreTable& table, const std::string& name) {
  ScoreTable renamed = {table.file, {}, table.lower_is_better};
  for (const auto& [key, value] : table.cells) {
    ScoreKey other = key;
    other.run.variant = name;
    renamed.cells.emplace(other, value);
  }
  for (const auto runs : {&ScoreTable::not_run, &ScoreTable::failed, &ScoreTable::camera_given})
    for (RunKey run : table.*runs) {
      run.variant = name;
      (renamed.*runs).insert(run);
    }
  table = std::move(renamed);
}

}  // namespace uniquadric
