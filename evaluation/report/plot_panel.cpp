#include "evaluation/report/plot_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace uniquadric {
namespace {

constexpr double kRoom = 0.05;  // share of the range
constexpr double kPixelsPerTick_x = 80, kPixelsPerTick_y = 34;

int tick_count(double size_px, double each_px) {
  return std::max(3, static_cast<int>(size_px / each_px));
}

}  // namespace

PlotRange padded_range(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double middle = (*least + *most) / 2;
  // Where there is no range to speak of, rounding must not fill the plot.
  const double half =
      std::max((*most - *least) / 2 * (1 + 2 * kRoom), 1e-9 * std::max(std::abs(middle), 1.0));
  return {middle - half, middle + half};
}

std::vector<double> round_ticks(const PlotRange& range, int count) {
  const double rough = (range.max - range.min) / count;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double step = power * (rough <= 1.5 * power   ? 1
                               : rough <= 3.5 * power ? 2
                               : rough <= 7.5 * power ? 5
                                                      : 10);
  std::vector<double> ticks;
  for (double i = std::ceil(range.min / step); i * step <= range.max; ++i) ticks.push_back(i * step + 0.0);
  return ticks;
}

void draw_axes(Picture& picture, const PlotPanel& panel, const std::string& x_name,
               const std::string& y_name) {
  const double bottom = panel.top + panel.height, right = panel.left + panel.width;
  const auto add = [&](TextKind kind, TextAnchor anchor, double x, double y, std::string text) {
    picture.parts.emplace_back(PictureText{kind, anchor, {x, y}, std::move(text)});
  };
  for (const double value : round_ticks(panel.x, tick_count(panel.width, kPixelsPerTick_x))) {
    const double x = panel.x_of(value);
    picture.parts.emplace_back(PictureLine{LineKind::grid, {{x, panel.top}, {x, bottom}}, ""});
    add(TextKind::tick, TextAnchor::middle, x, bottom + 16, fmt::format("{:.6g}", value));
  }
  for (const double value : round_ticks(panel.y, tick_count(panel.height, kPixelsPerTick_y))) {
    const double y = panel.y_of(value);
    picture.parts.emplace_back(PictureLine{LineKind::grid, {{panel.left, y}, {right, y}}, ""});
    add(TextKind::tick, TextAnchor::end, panel.left - 7, y + 4, fmt::format("{:.6g}", value));
  }
  add(TextKind::tick, TextAnchor::middle, panel.left + panel.width / 2, bottom + 32, x_name);
  add(TextKind::name, TextAnchor::start, panel.left, panel.top - 8, y_name);
}

std::vector<PicturePoint> panel_line(const PlotPanel& panel, const std::vector<double>& x,
                                     const std::vector<double>& y) {
  const auto tenth = [](double value) { return std::round(10 * value) / 10; };
  std::vector<PicturePoint> points;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const PicturePoint point{tenth(panel.x_of(x[i])), tenth(panel.y_of(y[i]))};
    if (points.empty() || point != points.back()) points.push_back(point);
  }
  return points;
}

}  // namespace uniquadric
