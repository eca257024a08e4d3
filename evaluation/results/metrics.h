#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace uniquadric {

/// Whose figure a metric is: an object's, the camera's, the tracking's as a whole, or the run's.
enum class MetricScope { object = 1, camera = 2, all = 4 };

/// One figure of scores.csv (names: CLI contract).
struct Metric {
  const char* name;         ///< with its unit, as in scores.csv
  const char* label;        ///< short, for table heads
  const char* unit;         ///< empty for ratios and counts
  bool lower_is_better;     ///< else higher
  int scopes;               ///< MetricScope bits
  const char* pointer;      ///< JSON pointer from the object, the camera, or the whole evaluation.json
  const char* definition;   ///< a sentence or two for readers of the report
  bool by_variant = false;  ///< no failure of a variant none of whose runs has it: it does not write such
  bool is_part = false;  ///< another metric over some of its frames: `compare` judges it only where asked to
};

/// All metrics, in the order of scores.csv.
std::span<const Metric> all_metrics();

/// A metric's name of today for one that scores.csv of earlier versions has; other names as they are.
std::string_view current_name(std::string_view name);

/// The metric of that name; null: there is none.
const Metric* metric_of_name(std::string_view name);

/// The same; asserts that there is one.
const Metric& find_metric(std::string_view name);

/// "APE.t [m]", or the label alone.
std::string label_with_unit(const Metric& metric);

/// Why a value cannot be the metric's, as "1.5 is more than 1"; nothing of one that can. Errors, counts and
/// times are 0 at least, what is better higher is a share (MOTA may be negative).
std::optional<std::string> impossible(const Metric& metric, double value);

/// Columns of the short tables, in order.
std::span<const char* const> summary_metrics();

}  // namespace uniquadric
