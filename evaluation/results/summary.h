#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "evaluation/results/metrics.h"
#include "evaluation/results/paper_table.h"
#include "evaluation/results/results.h"

namespace uniquadric {

/// A metric over the seeds of one (scene, object, variant).
struct Spread {
  double median = 0, min = 0, max = 0;
  int n = 0;
  bool best = false;  ///< of the variants compared (summarize), none has a better median and one a worse
  double mean = 0;
  std::optional<double> interval;  ///< half the mean's 95 % confidence interval; nothing of a single run
  std::vector<double> values;      ///< in order of the runs
};

/// A row of the summary.
struct SummaryRow {
  std::string scene, object, variant;
  int runs = 0, good = 0;                ///< cells tried or planned, and those with errors of this object
  bool given = false;                    ///< the camera's poses were given in all runs: no estimate of them
  std::map<std::string, Spread> spread;  ///< by metric name; absent where no run has the figure
  std::optional<PaperRow> paper;         ///< of objects in scenes made after the paper's
};

/// Rows by scene, object (`camera` and `all` last) and variant, in the order of cells.csv. A scene without a
/// single good run has one row a variant with the object `all`. A run whose evaluation lists the object but
/// never met it (coverage 0, or no APE) has no result. The best of a metric is sought among the variants of
/// the same scene, object and output that have the most runs with a result, and of those the most with this
/// metric: who loses the hard runs is not the better for it. Given cameras are left out.
std::vector<SummaryRow> summarize(const Results& results);

/// The rows of a summary over many objects: of each variant, with its later outputs, the medians of its
/// objects' figures. `min`, `max` and `n` are over objects, `runs` and `good` over their runs; no row is
/// best.
class OverallRows {
 public:
  void add(const std::vector<SummaryRow>& summary);
  /// In the order in which the variants came; `scene` is the rows' scene.
  std::vector<SummaryRow> rows(const std::string& scene) const;

 private:
  struct OfVariant {
    std::string variant;
    int objects = 0, runs = 0, good = 0;
    std::map<std::string, std::vector<double>> medians;
  };
  std::vector<OfVariant> variants_;
};

/// The variant's name without its later output.
std::string_view without_output(std::string_view variant);

/// The output of a variant's row: "@final" of VARIANT@final; empty: what was known at each frame.
std::string output_of(const std::string& variant);

/// Whether a table says `given` in place of the row's figure: errors of poses that were given.
bool shows_given(const SummaryRow& row, const Metric& metric);

/// What a table has of a metric: its median as text, `none` where there is none, `given`; the best within
/// `marks`, as {"**", "**"}.
std::string shown_figure(const SummaryRow& row, const char* metric, const char* none,
                         const std::array<const char*, 2>& marks);

/// Whether the row at `i` is the last of its scene and object.
bool ends_object(const std::vector<SummaryRow>& rows, std::size_t i);

/// Plain text, the paper's two systems under objects that it has; camera and tracking are left to the report.
std::string summary_text(const std::vector<SummaryRow>& rows);

/// Plain text of one evaluation: a line an object and one of the camera, `-` where there is no figure.
std::string evaluation_text(const CellEvaluation& evaluation);

/// The median of values (of an even number the mean of the middle two); asserts that there are any.
double median(const std::vector<double>& values);

/// Half the width of the mean's 95 % confidence interval: Student's t times the standard error (ddof 1).
/// Nothing of fewer than two values.
std::optional<double> confidence_interval(const std::vector<double>& values);

/// Digits for people: two to four significant ones, no exponent for ordinary sizes.
std::string format_figure(double value);

}  // namespace uniquadric
