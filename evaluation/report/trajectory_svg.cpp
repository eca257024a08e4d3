#include "evaluation/report/trajectory_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/seconds.h"
#include "evaluation/report/markup.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/report/svg_panel.h"

namespace uniquadric {
namespace {

// Sizes in the picture's own units, a pixel where it is shown at its size.
constexpr double kWidth = 940, kPathSize = 400, kMargin = 62, kTop = 96, kGap = 64;
constexpr double kErrorHeight = 110;
constexpr double kAxisHeight = (kPathSize - 2 * kGap) / 3;
constexpr double kRightColumn = kMargin + kPathSize + 150;
constexpr double kRightWidth = kWidth - kRightColumn - 20;

// From small to large errors, on white and on dark.
constexpr std::array kRamp = {"#2c7bb6", "#2f9fb0", "#4fb58a", "#8fb84a",
                              "#c9a92e", "#e8862e", "#e3592a", "#c92a2a"};

std::string colour_rules(const SvgColours& colours) {
  return fmt::format(
      "text{{fill:{1}}}.back{{fill:{0}}}.tick{{fill:{2}}}.grid{{stroke:{3}}}.reference{{stroke:{2}}}"
      ".estimate{{stroke:{4}}}\n",
      colours.back, colours.text, colours.quiet, colours.grid, colours.variant[0]);
}

const char* const kRules =
    "text{font:12px system-ui,\"Segoe UI\",\"DejaVu Sans\",sans-serif}.tick{font-size:11px}"
    ".title,.name{font-weight:600}\n"
    "path{fill:none}.reference{stroke-width:1.2;stroke-dasharray:5 3}.estimate{stroke-width:1.6}"
    ".coloured{stroke-width:2.2;stroke-linecap:round;stroke-linejoin:round}\n";

std::vector<double> coordinate(const std::vector<Pose>& poses, int axis) {
  std::vector<double> values;
  for (const Pose& pose : poses) values.push_back(pose.translation[axis]);
  return values;
}

std::vector<double> both(std::vector<double> a, const std::vector<double>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

std::vector<double> times_s(const PosePairs& pairs) {
  std::vector<double> times;
  for (const std::int64_t stamp_ns : pairs.stamps_ns) times.push_back(seconds(pairs.stamps_ns[0], stamp_ns));
  return times;
}

std::string line(const char* kind, const std::string& path) {
  return fmt::format("<path class=\"{}\" d=\"{}\"/>\n", kind, path);
}

std::string name_of(const ErrorSeries& series) {
  const std::string unit = unit_of(series.part);
  return fmt::format("{} {}{}", series.relation == PoseRelation::ape ? "APE" : "RPE", to_string(series.part),
                     unit.empty() ? "" : " [" + unit + "]");
}

// In order of time: with all pairs a short step may start after a long one and end before it.
ErrorSeries by_time(const ErrorSeries& series) {
  std::vector<std::size_t> order(series.at.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return series.at[a] < series.at[b]; });
  ErrorSeries sorted{series.relation, series.part, {}, {}};
  for (const std::size_t k : order) {
    sorted.at.push_back(series.at[k]);
    sorted.values.push_back(series.values[k]);
  }
  return sorted;
}

// A metre is as long to the right as upwards.
SvgPanel path_panel(const PosePairs& pairs) {
  SvgPanel panel{kMargin, kTop, kPathSize, kPathSize, {}, {}};
  panel.x = padded_range(both(coordinate(pairs.reference, 0), coordinate(pairs.estimate, 0)));
  panel.y = padded_range(both(coordinate(pairs.reference, 1), coordinate(pairs.estimate, 1)));
  const double half = std::max(panel.x.max - panel.x.min, panel.y.max - panel.y.min) / 2;
  for (SvgRange* range : {&panel.x, &panel.y}) {
    const double middle = (range->min + range->max) / 2;
    *range = {middle - half, middle + half};
  }
  return panel;
}

std::size_t colour_of(double value, const SvgRange& range) {
  const double share = range.max > range.min ? (value - range.min) / (range.max - range.min) : 0;
  return std::min(static_cast<std::size_t>(share * static_cast<double>(kRamp.size())), kRamp.size() - 1);
}

// A stroke for each run of one colour: a value colours the way from where the one before it was taken.
std::string coloured_path(const SvgPanel& panel, const PosePairs& pairs, const ErrorSeries& series,
                          const SvgRange& range) {
  std::string text;
  std::vector<double> x, y;
  std::size_t colour = 0, begin = 0;
  const auto end_stroke = [&] {
    if (x.size() > 1)
      text += fmt::format("<path class=\"coloured\" stroke=\"{}\" d=\"{}\"/>\n", kRamp[colour],
                          panel_line(panel, x, y));
    x.clear();
    y.clear();
  };
  for (std::size_t k = 0; k < series.at.size(); ++k) {
    if (const std::size_t own = colour_of(series.values[k], range); own != colour) {
      end_stroke();
      colour = own;
    }
    for (std::size_t i = x.empty() ? begin : begin + 1; i <= series.at[k]; ++i) {
      x.push_back(pairs.estimate[i].translation.x());
      y.push_back(pairs.estimate[i].translation.y());
    }
    begin = series.at[k];
  }
  end_stroke();
  return text;
}

std::string colour_bar(const SvgRange& range, const std::string& name) {
  const double left = kMargin + kPathSize + 18, height = kPathSize / static_cast<double>(kRamp.size());
  std::string text;
  for (std::size_t i = 0; i < kRamp.size(); ++i)
    text += fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"14\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                        left, kTop + kPathSize - height * static_cast<double>(i + 1), height, kRamp[i]);
  for (const auto& [value, y] : {std::pair(range.max, kTop + 10), std::pair(range.min, kTop + kPathSize)})
    text +=
        fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\">{:.3g}</text>\n", left + 19, y, value);
  return text + fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
                            left + 14, kTop - 8, escaped(name));
}

std::string path_plot(const TrajectoryComparison& c) {
  const SvgPanel panel = path_panel(c.pairs);
  const ErrorSeries series = by_time(c.errors.front());
  const auto [least, most] = std::minmax_element(series.values.begin(), series.values.end());
  const SvgRange range{*least, *most};
  return panel_axes(panel, "x [m]", "y [m]") +
         line("reference",
              panel_line(panel, coordinate(c.pairs.reference, 0), coordinate(c.pairs.reference, 1))) +
         coloured_path(panel, c.pairs, series, range) + colour_bar(range, name_of(series));
}

std::string axis_plots(const PosePairs& pairs, const std::vector<double>& times) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    const auto reference = coordinate(pairs.reference, axis), estimate = coordinate(pairs.estimate, axis);
    const SvgPanel panel{
        kRightColumn, kTop + axis * (kAxisHeight + kGap), kRightWidth,
        kAxisHeight,  {times.front(), times.back()},      padded_range(both(reference, estimate))};
    text += panel_axes(panel, "time [s]", fmt::format("{} [m]", "xyz"[axis]));
    text += line("estimate", panel_line(panel, times, estimate));
    text += line("reference", panel_line(panel, times, reference));
  }
  return text;
}

std::string error_plot(const ErrorSeries& series, const std::vector<double>& times, double top) {
  SvgPanel panel{kMargin,
                 top,
                 kWidth - kMargin - 20,
                 kErrorHeight,
                 {times.front(), times.back()},
                 padded_range(series.values)};
  panel.y.min = 0;
  std::vector<double> at;
  for (const std::size_t k : series.at) at.push_back(times[k]);
  return panel_axes(panel, "time [s]", name_of(series)) +
         line("estimate", panel_line(panel, at, series.values));
}

std::string head(const std::string& title) {
  const double y = 46;
  return fmt::format("<text class=\"title\" x=\"{0:.1f}\" y=\"26\">{1}</text>\n", kMargin, escaped(title)) +
         line("reference", fmt::format("M{:.1f} {:.1f}h28", kMargin, y)) +
         fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">reference</text>\n", kMargin + 36, y + 4) +
         line("estimate", fmt::format("M{:.1f} {:.1f}h28", kMargin + 110, y)) +
         fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">estimate</text>\n", kMargin + 146, y + 4);
}

}  // namespace

std::string trajectory_svg(const TrajectoryComparison& c, const std::string& title) {
  const std::vector<double> times = times_s(c.pairs);
  double top = kTop + kPathSize + kGap + 10;
  std::string errors;
  for (const ErrorSeries& series : c.errors) {
    errors += error_plot(by_time(series), times, top);
    top += kErrorHeight + kGap;
  }
  return fmt::format(
             "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
             "height=\"{1:.0f}\" role=\"img\" aria-label=\"Two trajectories and their errors\">\n",
             kWidth, top - 10) +
         svg_ground(kRules, colour_rules) + head(title) + path_plot(c) + axis_plots(c.pairs, times) + errors +
         "</svg>\n";
}

}  // namespace uniquadric
