#include "evaluation/report/trajectory_picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "core/base/seconds.h"
#include "evaluation/report/plot_panel.h"

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

void draw_line(Picture& picture, LineKind kind, std::vector<PicturePoint> points) {
  picture.parts.emplace_back(PictureLine{kind, std::move(points), ""});
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
PlotPanel path_panel(const PosePairs& pairs) {
  PlotPanel panel{kMargin, kTop, kPathSize, kPathSize, {}, {}};
  panel.x = padded_range(both(coordinate(pairs.reference, 0), coordinate(pairs.estimate, 0)));
  panel.y = padded_range(both(coordinate(pairs.reference, 1), coordinate(pairs.estimate, 1)));
  const double half = std::max(panel.x.max - panel.x.min, panel.y.max - panel.y.min) / 2;
  for (PlotRange* range : {&panel.x, &panel.y}) {
    const double middle = (range->min + range->max) / 2;
    *range = {middle - half, middle + half};
  }
  return panel;
}

std::size_t colour_of(double value, const PlotRange& range) {
  const double share = range.max > range.min ? (value - range.min) / (range.max - range.min) : 0;
  return std::min(static_cast<std::size_t>(share * static_cast<double>(kRamp.size())), kRamp.size() - 1);
}

// A stroke for each run of one colour: a value colours the way from where the one before it was taken.
void draw_coloured_path(Picture& picture, const PlotPanel& panel, const PosePairs& pairs,
                        const ErrorSeries& series, const PlotRange& range) {
  std::vector<double> x, y;
  std::size_t colour = 0, begin = 0;
  const auto end_stroke = [&] {
    if (x.size() > 1)
      picture.parts.emplace_back(PictureLine{LineKind::coloured, panel_line(panel, x, y), kRamp[colour]});
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
}

void draw_colour_bar(Picture& picture, const PlotRange& range, const std::string& name) {
  const double left = kMargin + kPathSize + 18, height = kPathSize / static_cast<double>(kRamp.size());
  for (std::size_t i = 0; i < kRamp.size(); ++i)
    picture.parts.emplace_back(
        PictureBox{{left, kTop + kPathSize - height * static_cast<double>(i + 1)}, 14, height, kRamp[i]});
  for (const auto& [value, y] : {std::pair(range.max, kTop + 10), std::pair(range.min, kTop + kPathSize)})
    picture.parts.emplace_back(
        PictureText{TextKind::tick, TextAnchor::start, {left + 19, y}, fmt::format("{:.3g}", value)});
  picture.parts.emplace_back(PictureText{TextKind::name, TextAnchor::end, {left + 14, kTop - 8}, name});
}

void draw_paths(Picture& picture, const TrajectoryComparison& c) {
  const PlotPanel panel = path_panel(c.pairs);
  const ErrorSeries series = by_time(c.errors.front());
  const auto [least, most] = std::minmax_element(series.values.begin(), series.values.end());
  const PlotRange range{*least, *most};
  draw_axes(picture, panel, "x [m]", "y [m]");
  draw_line(picture, LineKind::reference,
            panel_line(panel, coordinate(c.pairs.reference, 0), coordinate(c.pairs.reference, 1)));
  draw_coloured_path(picture, panel, c.pairs, series, range);
  draw_colour_bar(picture, range, name_of(series));
}

void draw_coordinates(Picture& picture, const PosePairs& pairs, const std::vector<double>& times) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto reference = coordinate(pairs.reference, axis), estimate = coordinate(pairs.estimate, axis);
    const PlotPanel panel{
        kRightColumn, kTop + axis * (kAxisHeight + kGap), kRightWidth,
        kAxisHeight,  {times.front(), times.back()},      padded_range(both(reference, estimate))};
    draw_axes(picture, panel, "time [s]", fmt::format("{} [m]", "xyz"[axis]));
    draw_line(picture, LineKind::estimate, panel_line(panel, times, estimate));
    draw_line(picture, LineKind::reference, panel_line(panel, times, reference));
  }
}

void draw_error(Picture& picture, const ErrorSeries& series, const std::vector<double>& times, double top) {
  PlotPanel panel{kMargin,
                  top,
                  kWidth - kMargin - 20,
                  kErrorHeight,
                  {times.front(), times.back()},
                  padded_range(series.values)};
  panel.y.min = 0;
  std::vector<double> at;
  for (const std::size_t k : series.at) at.push_back(times[k]);
  draw_axes(picture, panel, "time [s]", name_of(series));
  draw_line(picture, LineKind::estimate, panel_line(panel, at, series.values));
}

void draw_head(Picture& picture, const std::string& title) {
  const double y = 46;
  const auto add = [&](TextKind kind, double x, double base, const std::string& text) {
    picture.parts.emplace_back(PictureText{kind, TextAnchor::start, {x, base}, text});
  };
  add(TextKind::title, kMargin, 26, title);
  draw_line(picture, LineKind::reference, {{kMargin, y}, {kMargin + 28, y}});
  add(TextKind::plain, kMargin + 36, y + 4, "reference");
  draw_line(picture, LineKind::estimate, {{kMargin + 110, y}, {kMargin + 138, y}});
  add(TextKind::plain, kMargin + 146, y + 4, "estimate");
}

}  // namespace

Picture trajectory_picture(const TrajectoryComparison& c, const std::string& title) {
  const std::vector<double> times = times_s(c.pairs);
  Picture picture{kWidth, 0, "Two trajectories and their errors", {}};
  draw_head(picture, title);
  draw_paths(picture, c);
  draw_coordinates(picture, c.pairs, times);
  double top = kTop + kPathSize + kGap + 10;
  for (const ErrorSeries& series : c.errors) {
    draw_error(picture, by_time(series), times, top);
    top += kErrorHeight + kGap;
  }
  picture.height = top - 10;
  return picture;
}

}  // namespace uniquadric
