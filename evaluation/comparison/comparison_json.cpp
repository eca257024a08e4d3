#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/version.h"
#include "evaluation/comparison/score_comparison.h"

namespace uniquadric {
namespace {
using nlohmann::json;

constexpr int kSchema = 2;

json to_json(const std::optional<double>& value) {
  return value ? json(*value) : json(nullptr);
}

// "no proven change" as no_proven_change
std::string key_of(std::string text) {
  std::replace(text.begin(), text.end(), ' ', '_');
  return text;
}

const char* name_of(ChangeScale scale) {
  return scale == ChangeScale::ratio ? "ln_ratio" : "difference";
}

json to_json(const PlaceChange& place) {
  return {{"sequence", place.sequence},   {"object", place.object},      {"loss", place.loss},
          {"seeds", place.losses.size()}, {"p_worse", to_json(place.p)}, {"worse", place.worse}};
}

json to_json(const MetricChange& change) {
  json result = {{"variant", change.variant},
                 {"metric", change.metric},
                 {"of", change.subjects},
                 {"verdict", key_of(to_string(change.verdict))},
                 {"reason", to_string(change.reason)},
                 {"better", change.rule.lower_is_better ? "lower" : "higher"},
                 {"scale", name_of(change.rule.scale)},
                 {"margin", change.rule.margin},
                 {"place_margin", change.rule.place_margin},
                 {"a", change.a},
                 {"b", change.b},
                 {"loss", change.loss},
                 {"noise", change.noise},
                 {"provable", to_json(change.provable)},
                 {"judged_by_place", change.judged_by_place},
                 {"sequences", change.sequences},
                 {"pairs", change.pairs},
                 {"pairs_differing", change.test.differing},
                 {"exact", change.test.exact},
                 {"p_worse", change.test.p_above},
                 {"p_better", change.test.p_below},
                 {"p_worse_holm", to_json(change.p_worse)},
                 {"p_better_holm", to_json(change.p_better)}};
  result["places"] = json::array();
  for (const PlaceChange& place : change.places) result["places"].push_back(to_json(place));
  return result;
}

json to_json(const std::vector<Gap>& gaps) {
  json list = json::array();
  for (const Gap& gap : gaps)
    list.push_back({{"sequence", gap.run.sequence},
                    {"variant", gap.run.variant},
                    {"seed", gap.run.seed},
                    {"object", gap.object.empty() ? json(nullptr) : json(gap.object)},
                    {"metrics", gap.metrics}});
  return list;
}

}  // namespace

std::string comparison_json(const ScoreComparison& c) {
  json root = {
      {"schema", kSchema},
      {"program", kProgram},
      {"a", c.a},
      {"b", c.b},
      {"answer", to_string(c.answer)},
      {"alpha",
       {{"all", c.options.alpha}, {"place", c.options.place_alpha}, {"suspect", c.options.suspect_p}}},
      {"pairs", c.pairing.pairs.size()},
      {"failed_in_both", c.pairing.failed_in_both},
      {"camera_given", c.pairing.camera_given},
      {"new_failures", to_json(c.pairing.new_failures)},
      {"mended", to_json(c.pairing.mended)},
      {"missing_in_a", to_json(c.pairing.missing_in_a)},
      {"missing_in_b", to_json(c.pairing.missing_in_b)},
      {"metrics_of_a_alone", c.pairing.metrics_of_a_alone},
      {"measured_on_one_side", c.pairing.measured_on_one_side},
      {"new_in_b", c.pairing.new_in_b},
      {"scenes_of_b_alone", c.pairing.scenes_of_b_alone},
      {"variants_of_b_alone", c.pairing.variants_of_b_alone},
      {"metrics_of_b_alone", c.pairing.metrics_of_b_alone}};
  for (const Verdict verdict :
       {Verdict::worse, Verdict::suspect, Verdict::not_judged, Verdict::better, Verdict::no_proven_change})
    root["counts"][key_of(to_string(verdict))] = count_verdicts(c, verdict);
  root["metrics"] = json::array();
  for (const MetricChange& change : c.metrics) root["metrics"].push_back(to_json(change));
  return root.dump(2, ' ', false, json::error_handler_t::replace) + "\n";
}

}  // namespace uniquadric
