#include "evaluation/comparison/comparison_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "evaluation/comparison/provable.h"
#include "evaluation/comparison/verdict.h"
#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostGaps = 12, kMostNames = 4;
constexpr double kTenPercent = 10, kThousandPercent = 1000;

bool has_variants(const ScoreComparison& comparison) {
  return std::any_of(comparison.metrics.begin(), comparison.metrics.end(), [&](const MetricChange& change) {
    return change.variant != comparison.metrics.front().variant;
  });
}

// Of the value, not of the loss: an IoU that falls has a minus.
std::string format_change(const ChangeRule& rule, double loss) {
  if (loss == 0) return "0";
  const double change = rule.lower_is_better ? loss : -loss;
  const char* const sign = change > 0 ? "+" : "-";
  if (rule.scale == ChangeScale::difference) return sign + format_figure(std::abs(change));
  const double percent = 100 * std::expm1(change), size = std::abs(percent);
  if (size >= kThousandPercent) return fmt::format("x {}", format_figure(std::exp(change)));
  return fmt::format("{}{:.{}f} %", sign, size, size < kTenPercent ? 1 : 0);
}

// From an error of 0 there is no ratio to tell.
std::string format_change(const MetricChange& change) {
  if (change.loss > 0 && counts_as_none(change.rule, change.a)) return "from none";
  return format_change(change.rule, change.loss);
}

// A p of 0 is none: below this neither the draws nor the t test's assumption tells sizes apart.
constexpr double kLeastShownP = 1e-4;

std::string format_p(double p) {
  if (p < kLeastShownP) return fmt::format("< {:.4f}", kLeastShownP);
  return fmt::format("{:.{}f}", p, p < 0.001 ? 4 : 3);
}

std::string significance(const MetricChange& change) {
  const auto& p = change.verdict == Verdict::better ? change.p_better : change.p_worse;
  return p ? format_p(*p) : "-";
}

// The smallest loss that would have been worse: of the mean, or at least of one object on one sequence.
std::string provable(const MetricChange& change) {
  if (change.provable) return format_change(change.rule, *change.provable);
  if (change.judged_by_place) return format_change(change.rule, change.rule.place_margin) + " of one";
  return change.verdict == Verdict::not_judged ? "none" : "-";
}

// In the short table: what is proven, what is worth a look, and losses that cannot be proven.
bool is_told(const MetricChange& change) {
  if (change.verdict == Verdict::not_judged) return shows_loss(change);
  return change.verdict != Verdict::no_proven_change;
}

// The place with the greatest loss, of those that are proven where they decided; empty where there is nothing
// to tell.
std::string worst_place(const MetricChange& change, const GateOptions& options) {
  const auto proven = [&](const PlaceChange& place) { return is_proven(place, options); };
  const auto& places = change.places;
  const auto worst = change.reason == VerdictReason::one_place
                         ? std::find_if(places.begin(), places.end(), proven)
                         : places.begin();
  if (places.size() < 2 || worst->loss <= change.rule.margin) return "";
  std::string text =
      fmt::format("{}/{} {}", worst->sequence, worst->object, format_change(change.rule, worst->loss));
  if (proven(*worst)) text += fmt::format(" (p {})", format_p(*worst->p));
  return text;
}

std::string count_of(std::size_t n, const char* what) {
  return fmt::format("{} {}{}", n, what, n == 1 ? "" : "s");
}

// "1-3, 5"
std::string ranges(const std::vector<std::uint64_t>& seeds) {
  std::string text;
  for (std::size_t first = 0, last = 0; first < seeds.size(); first = ++last) {
    while (last + 1 < seeds.size() && seeds[last + 1] == seeds[last] + 1) ++last;
    text += fmt::format("{}{}", text.empty() ? "" : ", ", seeds[first]);
    if (last > first) text += fmt::format("-{}", seeds[last]);
  }
  return text;
}

std::string names_of(const std::vector<std::string>& metrics) {
  const std::size_t named = metrics.size() > kMostNames + 1 ? kMostNames : metrics.size();
  std::string text =
      fmt::format("{}", fmt::join(metrics.begin(), metrics.begin() + std::ptrdiff_t(named), ", "));
  if (named < metrics.size()) text += fmt::format(" and {} more", metrics.size() - named);
  return text;
}

std::string describe(const Gap& gap, const std::vector<std::uint64_t>& seeds) {
  const std::string runs =
      fmt::format("{} seed{} {}", gap.run.variant, seeds.size() == 1 ? "" : "s", ranges(seeds));
  if (gap.object.empty())
    return fmt::format("{} {}: the whole run{}", gap.run.sequence, runs, seeds.size() == 1 ? "" : "s");
  return fmt::format("{}/{} {}: {}", gap.run.sequence, gap.object, runs, names_of(gap.metrics));
}

// Seeds that lack the same are one line.
void add_list(const char* title, const std::vector<Gap>& gaps, std::vector<GapList>& lists) {
  if (gaps.empty()) return;
  std::map<Gap, std::vector<std::uint64_t>> seeds;
  for (const Gap& gap : gaps) {
    Gap of_any_seed = gap;
    of_any_seed.run.seed = 0;
    seeds[of_any_seed].push_back(gap.run.seed);
  }
  GapList& list = lists.emplace_back(GapList{title, {}});
  for (const auto& [gap, of] : seeds) {
    if (list.lines.size() + 1 == kMostGaps && seeds.size() > kMostGaps) break;
    list.lines.push_back(describe(gap, of));
  }
  if (list.lines.size() < seeds.size())
    list.lines.push_back(fmt::format("and {} more", seeds.size() - list.lines.size()));
}

// By variant, subjects and number of pairs.
void add_not_judged(const ScoreComparison& comparison, std::vector<GapList>& lists) {
  std::map<std::string, std::vector<std::string>> groups;
  for (const MetricChange& change : comparison.metrics)
    if (change.verdict == Verdict::not_judged)
      groups[fmt::format("{} {}, {} of {}", change.variant, change.subjects, count_of(change.pairs, "pair"),
                         count_of(change.sequences, "sequence"))]
          .push_back(change.metric);
  if (groups.empty()) return;
  GapList& list = lists.emplace_back(GapList{"not judged (too few pairs to prove any loss)", {}});
  for (auto& [group, metrics] : groups) {
    std::sort(metrics.begin(), metrics.end());
    list.lines.push_back(group + ": " + names_of(metrics));
  }
}

}  // namespace

std::string sides_of(const ScoreComparison& comparison) {
  return has_variants(comparison) ? "<<<<>>>>><<" : "<<<>>>>><<";
}

TableLines change_table(const ScoreComparison& comparison, bool all) {
  const bool with_variant = has_variants(comparison);
  TableLines lines = {{"verdict", "metric", "of", "A", "B", "change", "p", "provable", "why", "most at"}};
  if (with_variant) lines.front().insert(lines.front().begin() + 1, "variant");
  for (const MetricChange& change : comparison.metrics) {
    if (!all && !is_told(change)) continue;
    lines.push_back({to_string(change.verdict), change.metric, change.subjects, format_figure(change.a),
                     format_figure(change.b), format_change(change), significance(change), provable(change),
                     to_string(change.reason), worst_place(change, comparison.options)});
    if (with_variant) lines.back().insert(lines.back().begin() + 1, change.variant);
  }
  return lines;
}

std::string describe_change(const MetricChange& change) {
  const char* const reason = to_string(change.reason);
  return fmt::format("{}{}{}: A {}, B {}, {}, p {}", to_string(change.verdict), *reason ? ", " : "", reason,
                     format_figure(change.a), format_figure(change.b), format_change(change),
                     significance(change));
}

std::string headline(const ScoreComparison& comparison) {
  const auto count = [&](Verdict verdict) { return count_verdicts(comparison, verdict); };
  const Pairing& pairing = comparison.pairing;
  std::string text = fmt::format("{}: of {} {} worse, {} suspect, {} better, {} with no proven change",
                                 to_string(comparison.answer), count_of(comparison.metrics.size(), "metric"),
                                 count(Verdict::worse), count(Verdict::suspect), count(Verdict::better),
                                 count(Verdict::no_proven_change));
  if (count(Verdict::not_judged) > 0) text += fmt::format(", {} not judged", count(Verdict::not_judged));
  if (!pairing.new_failures.empty()) text += "; " + count_of(pairing.new_failures.size(), "new failure");
  if (!pairing.missing_in_b.empty()) text += fmt::format("; {} missing in B", pairing.missing_in_b.size());
  if (!pairing.missing_in_a.empty()) text += fmt::format("; {} missing in A", pairing.missing_in_a.size());
  if (!pairing.mended.empty()) text += fmt::format("; {} mended", pairing.mended.size());
  return text;
}

std::string extent(const ScoreComparison& comparison) {
  std::set<std::string> sequences, variants;
  std::set<std::uint64_t> seeds;
  for (const PairedScore& pair : comparison.pairing.pairs) {
    sequences.insert(pair.key.run.sequence);
    variants.insert(pair.key.run.variant);
    seeds.insert(pair.key.run.seed);
  }
  std::string text =
      fmt::format("{} of {}, {}, {}", count_of(comparison.pairing.pairs.size(), "paired figure"),
                  count_of(sequences.size(), "sequence"), count_of(variants.size(), "variant"),
                  count_of(seeds.size(), "seed"));
  if (comparison.pairing.failed_in_both > 0)
    text += fmt::format("; {} failed in both", comparison.pairing.failed_in_both);
  if (comparison.pairing.camera_given > 0)
    text += fmt::format("; {} of cameras whose poses were given", comparison.pairing.camera_given);
  if (comparison.pairing.measured_on_one_side > 0)
    text += fmt::format("; {} of time or memory on one side alone", comparison.pairing.measured_on_one_side);
  if (comparison.pairing.new_in_b > 0) text += fmt::format("; {} new in B", comparison.pairing.new_in_b);
  return text;
}

std::vector<GapList> gap_lists(const ScoreComparison& comparison) {
  const Pairing& pairing = comparison.pairing;
  std::vector<GapList> lists;
  add_not_judged(comparison, lists);
  if (!pairing.metrics_of_a_alone.empty())
    lists.push_back({"metrics of A alone", pairing.metrics_of_a_alone});
  if (!pairing.metrics_of_b_alone.empty())
    lists.push_back({"new metrics (of B alone)", pairing.metrics_of_b_alone});
  if (!pairing.scenes_of_b_alone.empty())
    lists.push_back({"new scenes (of B alone)", pairing.scenes_of_b_alone});
  if (!pairing.variants_of_b_alone.empty())
    lists.push_back({"new variants (of B alone)", pairing.variants_of_b_alone});
  add_list("new failures (with a figure in A, failed in B)", pairing.new_failures, lists);
  add_list("missing in B", pairing.missing_in_b, lists);
  add_list("missing in A", pairing.missing_in_a, lists);
  add_list("mended (failed in A, with a figure in B)", pairing.mended, lists);
  return lists;
}

}  // namespace uniquadric
