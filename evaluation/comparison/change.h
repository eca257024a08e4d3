#pragma once

#include <string>

namespace uniquadric {

/// How a metric's values of two sides are set against each other.
enum class ChangeScale {
  ratio,      ///< ln(B / A): errors, a tenth more is a tenth more for any size
  difference  ///< in the metric's own unit: what is bounded, counted or often 0
};

/// What holds for a metric: decided by its name and direction (docs/compare.md).
struct ChangeRule {
  bool lower_is_better = true;
  ChangeScale scale = ChangeScale::ratio;
  double margin = 0;  ///< a loss up to this never fails: ln 1.02, 0.005, or of counts and times their own
  double place_margin = 0;  ///< the same for the loss of one object on one sequence
  bool is_time = false;     ///< measured computing time: differs between equal runs
};

/// Computing time or memory (`_ms`, wall_time_s, cpu_time_s, peak_memory_mb): of the machine and its load,
/// too.
bool is_measured(const std::string& metric);

/// higher is better: difference, margin 0.005. Lower: difference for `id_switches` and `false_bodies` (margin
/// 0.1), `longest_gap_s` (0.05 s) and `semi_axes_change_occluded_max` (0.005), for which 0 is a common value;
/// ratio for the others (ln 1.02).
ChangeRule change_rule(const std::string& metric, bool lower_is_better);

/// The loss from `a` to `b`: positive is worse. By ratio, values count as at least 1e-9: 0 against 0 (or
/// against rounding) is no change, 0 against x is the finite, large loss from 1e-9.
double loss(const ChangeRule& rule, double a, double b);

/// Whether a value is so small that loss() takes it for 1e-9.
bool counts_as_none(const ChangeRule& rule, double value);

/// A value on the scale on which means are taken (the logarithm for ratios), and back.
double to_scale(const ChangeRule& rule, double value);
double from_scale(const ChangeRule& rule, double value);

}  // namespace uniquadric
