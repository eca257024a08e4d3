#include "evaluation/report/variant_figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "evaluation/report/plot_panel.h"
#include "evaluation/report/svg_colours.h"

namespace uniquadric {
namespace {

constexpr double kLeft = 170, kTop = 34, kPlot = 300, kRow = 20, kRight = 80;
constexpr double kSeed = 4, kMean = 8;   // sides of the marks
constexpr double kLogarithmicFrom = 20;  // times between the greatest and the least, as in page/ablation.js
constexpr double kLeastDecades = 0.1;    // beside the marks
constexpr double kLeastWidth = 0.01;     // half the axis, of the values: else its numbers look alike

using Rows = std::vector<const SummaryRow*>;

// Values as they are drawn.
struct Axis {
  bool logarithmic = false;
  PlotPanel panel;
  double of(double value) const {
    return panel.x_of(logarithmic ? std::max(std::log10(value), panel.x.min) : value);
  }
};

struct Interval {
  double low = 0, high = 0;
};

// Of IoU and coverage within what they can be.
Interval interval_of(const Spread& spread, const Metric& metric) {
  const double half = spread.interval.value_or(0);
  if (metric.lower_is_better) return {spread.mean - half, spread.mean + half};
  return {std::max(0.0, spread.mean - half), std::min(1.0, spread.mean + half)};
}

Axis axis_of(const Metric& metric, const Rows& rows) {
  std::vector<double> values, ends;
  for (const SummaryRow* row : rows) {
    const Spread& spread = row->spread.at(metric.name);
    const auto [low, high] = interval_of(spread, metric);
    values.insert(values.end(), spread.values.begin(), spread.values.end());
    ends.insert(ends.end(), {low, high});
  }
  const auto [least, most] = std::ranges::minmax(values);
  ends.insert(ends.end(), {least, most});
  const double middle = (least + most) / 2, narrow = kLeastWidth * std::abs(middle);
  ends.insert(ends.end(), {middle - narrow, middle + narrow});
  Axis axis{metric.lower_is_better && least > 0 && most > kLogarithmicFrom * least,
            {kLeft, kTop - 10, kPlot, kRow * static_cast<double>(rows.size()), padded_range(ends), {}}};
  if (axis.logarithmic)
    axis.panel.x = {std::log10(least) - kLeastDecades, std::log10(std::ranges::max(ends)) + kLeastDecades};
  return axis;
}

std::vector<double> ticks_of(const Axis& axis) {
  const PlotRange& range = axis.panel.x;
  if (!axis.logarithmic) return round_ticks(range, 3);
  std::vector<double> ticks;
  for (double decade = std::floor(range.min); decade <= range.max; ++decade)
    for (const double factor : {1, 2, 5})
      if (const double log = decade + std::log10(factor); log >= range.min && log <= range.max)
        ticks.push_back(std::pow(10, log));
  if (ticks.size() > 5)  // whole decades are enough
    std::erase_if(ticks, [](double tick) { return std::abs(std::remainder(std::log10(tick), 1)) > 1e-6; });
  return ticks;
}

void draw_mark(Picture& picture, double x, double y, double side, const std::string& colour) {
  picture.parts.emplace_back(PictureBox{{x - side / 2, y - side / 2}, side, side, colour});
}

void draw_row(Picture& picture, const Axis& axis, const Metric& metric, const SummaryRow& row, double y,
              const std::string& colour) {
  const Spread& spread = row.spread.at(metric.name);
  picture.parts.emplace_back(PictureText{TextKind::plain, TextAnchor::end, {kLeft - 8, y + 4}, row.variant});
  picture.parts.emplace_back(PictureText{
      TextKind::plain, TextAnchor::start, {kLeft + kPlot + 8, y + 4}, fmt::format("{:.3g}", spread.mean)});
  if (spread.interval) {
    const auto [low, high] = interval_of(spread, metric);
    picture.parts.emplace_back(
        PictureLine{LineKind::coloured, {{axis.of(low), y}, {axis.of(high), y}}, colour});
  }
  for (const double value : spread.values) draw_mark(picture, axis.of(value), y, kSeed, colour);
  draw_mark(picture, axis.of(spread.mean), y, kMean, colour);
}

Picture picture_of(const Metric& metric, const Rows& rows,
                   const std::function<std::string(const std::string&)>& colour_of) {
  const Axis axis = axis_of(metric, rows);
  const double bottom = axis.panel.top + axis.panel.height;
  const std::string title =
      fmt::format("{}, {} in {}", label_with_unit(metric), rows.front()->object, rows.front()->scene);
  Picture picture{kLeft + kPlot + kRight, bottom + 42, title, {}};
  picture.parts.emplace_back(PictureText{TextKind::title, TextAnchor::start, {8, 14}, title});
  for (const double tick : ticks_of(axis)) {
    const double x = axis.of(tick);
    picture.parts.emplace_back(PictureLine{LineKind::grid, {{x, axis.panel.top}, {x, bottom}}, ""});
    picture.parts.emplace_back(
        PictureText{TextKind::tick, TextAnchor::middle, {x, bottom + 16}, fmt::format("{:.4g}", tick)});
  }
  picture.parts.emplace_back(
      PictureText{TextKind::tick,
                  TextAnchor::middle,
                  {kLeft + kPlot / 2, bottom + 34},
                  "small: runs; large, and the number: their mean; bar: its 95 % interval"});
  for (std::size_t i = 0; i < rows.size(); ++i)
    draw_row(picture, axis, metric, *rows[i], kTop + kRow * static_cast<double>(i),
             colour_of(rows[i]->variant));
  return picture;
}

// Rows of one object that have the metric, those of given cameras left out.
Rows rows_of(const Rows& object, const Metric& metric) {
  Rows rows;
  for (const SummaryRow* row : object)
    if (!row->given && row->spread.contains(metric.name)) rows.push_back(row);
  return rows;
}

}  // namespace

std::vector<NamedPicture> variant_figures(const Results& results, const std::vector<SummaryRow>& summary) {
  const std::vector<std::string> variants = causal_variants_of(results);
  const auto colour_of = [&](const std::string& variant) -> std::string {
    const auto place = std::ranges::find(variants, without_output(variant)) - variants.begin();
    return kLightSvg.variant[static_cast<std::size_t>(place) % kLightSvg.variant.size()];
  };
  std::vector<NamedPicture> figures;
  Rows object;
  for (std::size_t i = 0; i < summary.size(); ++i) {
    object.push_back(&summary[i]);
    if (!ends_object(summary, i)) continue;
    for (const char* name : summary_metrics())
      if (const Rows rows = rows_of(object, find_metric(name)); rows.size() > 1)
        figures.push_back({figure_name({rows[0]->scene, rows[0]->object, name, "variants"}),
                           picture_of(find_metric(name), rows, colour_of)});
    object.clear();
  }
  return figures;
}

}  // namespace uniquadric
