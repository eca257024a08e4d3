#include "evaluation/comparison/change.h"

#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

const double kRatioMargin = std::log(1.02);      // SPEC
constexpr double kShareMargin = 0.005;           // SPEC: of IoU; ours: of all shares
constexpr double kSwitchesMargin = 0.1;          // ours: one switch in ten runs
constexpr double kFalseBodiesMargin = 0.1;       // ours: one false body in ten runs
constexpr double kGapMargin_s = 0.05;            // ours: a frame or two
const double kPlaceRatioMargin = std::log(1.1);  // ours: see place_margin in docs/compare.md
constexpr double kPlaceFactor = 5;               // ours: as ln 1.1 is to ln 1.02
// ours: m, rad, deg: below what any sensor tells, above the rounding of what is exactly right
constexpr double kLeastError = 1e-9;

ChangeRule by_difference(bool lower_is_better, double margin) {
  return {lower_is_better, ChangeScale::difference, margin, kPlaceFactor * margin};
}

}  // namespace

bool is_measured(const std::string& metric) {
  return metric.ends_with("_ms") || metric == "wall_time_s" || metric == "cpu_time_s" ||
         metric == "peak_memory_mb";
}

ChangeRule change_rule(const std::string& metric, bool lower_is_better) {
  if (!lower_is_better) return by_difference(false, kShareMargin);
  if (metric == "id_switches") return by_difference(true, kSwitchesMargin);
  if (metric == "false_bodies") return by_difference(true, kFalseBodiesMargin);
  if (metric == "longest_gap_s") return by_difference(true, kGapMargin_s);
  if (metric == "semi_axes_change_occluded_max") return by_difference(true, kShareMargin);
  return {true, ChangeScale::ratio, kRatioMargin, kPlaceRatioMargin, is_measured(metric)};
}

bool counts_as_none(const ChangeRule& rule, double value) {
  return rule.scale == ChangeScale::ratio && value <= kLeastError;
}

double to_scale(const ChangeRule& rule, double value) {
  return rule.scale == ChangeScale::ratio ? std::log(std::max(value, kLeastError)) : value;
}

double from_scale(const ChangeRule& rule, double value) {
  return rule.scale == ChangeScale::ratio ? std::exp(value) : value;
}

double loss(const ChangeRule& rule, double a, double b) {
  if (a == b) return 0;
  if (rule.scale == ChangeScale::ratio) return std::log(std::max(b, kLeastError) / std::max(a, kLeastError));
  return rule.lower_is_better ? b - a : a - b;
}

}  // namespace uniquadric
