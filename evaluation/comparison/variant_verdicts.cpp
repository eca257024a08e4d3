#include "evaluation/comparison/variant_verdicts.h"

#include <algorithm>
#include <map>
#include <set>

#include "evaluation/comparison/score_table.h"
#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {

using Place = std::pair<std::string, std::string>;  // scene, object

constexpr const char* kSolid = "iou3d_solid_mean";
constexpr const char* kEllipsoid = "iou3d_ellipsoid_mean";
constexpr const char* kBesideIou[] = {"ape_translation_rmse_m", "coverage"};

struct Gains {
  bool gains = false, loses = false;
  ObjectVerdict verdict() const {
    if (gains && loses) return ObjectVerdict::mixed;
    return gains ? ObjectVerdict::better : loses ? ObjectVerdict::worse : ObjectVerdict::alike;
  }
};

void add(const PlaceChange& place, const ChangeRule& rule, Gains& gains) {
  gains.gains = gains.gains || place.loss < -rule.place_margin;
  gains.loses = gains.loses || place.loss > rule.place_margin;
}

std::map<Place, Gains> gains_by_place(const ScoreComparison& comparison) {
  std::map<Place, Gains> all;
  std::set<Place> with_solid;
  for (const char* metric : {kSolid, kEllipsoid, kBesideIou[0], kBesideIou[1]})
    for (const MetricChange& change : comparison.metrics) {
      if (change.metric != metric || change.subjects != "objects") continue;
      for (const PlaceChange& place : change.places) {
        const Place at{place.sequence, place.object};
        if (change.metric == kSolid) with_solid.insert(at);
        if (change.metric != kEllipsoid || !with_solid.contains(at)) add(place, change.rule, all[at]);
      }
    }
  return all;
}

std::set<Place> places_of(const std::vector<Gap>& gaps) {
  std::set<Place> places;
  for (const Gap& gap : gaps) places.emplace(gap.run.sequence, gap.object);
  return places;
}

// A gap without an object is a whole run's.
bool holds(const std::set<Place>& places, const Place& place) {
  return places.contains(place) || places.contains({place.first, ""});
}

std::vector<ObjectChange> judge_objects(const std::vector<Place>& places, const ScoreComparison& comparison) {
  const auto gains = gains_by_place(comparison);
  const auto lost = places_of(comparison.pairing.new_failures), mended = places_of(comparison.pairing.mended);
  std::vector<ObjectChange> objects;
  for (const Place& place : places) {
    const auto& [scene, object] = place;
    const auto found = gains.find(place);
    if (holds(lost, place))
      objects.push_back({scene, object, ObjectVerdict::lost});
    else if (holds(mended, place))
      objects.push_back({scene, object, ObjectVerdict::mended});
    else if (found != gains.end())
      objects.push_back({scene, object, found->second.verdict()});
  }
  return objects;
}

}  // namespace

const char* to_string(ObjectVerdict verdict) {
  switch (verdict) {
    case ObjectVerdict::better:
      return "better";
    case ObjectVerdict::worse:
      return "worse";
    case ObjectVerdict::mixed:
      return "mixed";
    case ObjectVerdict::alike:
      return "alike";
    case ObjectVerdict::lost:
      return "lost";
    case ObjectVerdict::mended:
      return "mended";
  }
  return "";
}

void VariantVerdicts::add(const Results& results) {
  tables_.add(results, summary_metrics());
  for (const std::string& scene : scenes_of(results))
    for (const std::string& object : subjects_of(results, scene))
      if (is_object(object)) objects_.emplace_back(scene, object);
}

std::vector<VariantVerdict> VariantVerdicts::verdicts(std::size_t most) {
  auto tables = tables_.take();
  for (auto& [variant, table] : tables)
    rename_variant(table, "both");  // so that the runs are each other's pairs
  std::vector<VariantVerdict> verdicts;
  for (const auto& [baseline, of_baseline] : tables)
    for (const auto& [variant, of_variant] : tables) {
      if (variant == baseline || (tables.size() > most && baseline != tables.front().first)) continue;
      ScoreComparison comparison = compare_scores(of_baseline, of_variant);
      auto objects = judge_objects(objects_, comparison);
      verdicts.push_back({baseline, variant, std::move(objects), std::move(comparison.metrics)});
    }
  return verdicts;
}

std::vector<VariantVerdict> variant_verdicts(const Results& results, std::size_t most) {
  VariantVerdicts verdicts;
  verdicts.add(results);
  return verdicts.verdicts(most);
}

}  // namespace uniquadric
