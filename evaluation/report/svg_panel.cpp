#include "evaluation/report/svg_panel.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "evaluation/report/markup.h"

namespace uniquadric {
namespace {

constexpr double kRoom = 0.05;  // share of the range
constexpr double kPixelsPerTick_x = 80, kPixelsPerTick_y = 34;

int tick_count(double size_px, double each_px) {
  return std::max(3, static_cast<int>(size_px / each_px));
}

}  // namespace

SvgRange padded_range(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [least, most] = std::minmax_element(values.begin(), values.end());
  const double middle = (*least + *most) / 2;
  // Where there is no range to speak of, rounding must not fill the plot.
  const double half =
      std::max((*most - *least) / 2 * (1 + 2 * kRoom), 1e-9 * std::max(std::abs(middle), 1.0));
  return {middle - half, middle + half};
}

std::vector<double> round_ticks(const SvgRange& range, int count) {
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

std::string panel_axes(const SvgPanel& panel, const std::string& x_name, const std::string& y_name) {
  const double bottom = panel.top + panel.height;
  std::string text;
  for (const double value : round_ticks(panel.x, tick_count(panel.width, kPixelsPerTick_x))) {
    text += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}v{:.1f}\"/>", panel.x_of(value), panel.top,
                        panel.height);
    text +=
        fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{:.6g}</text>\n",
                    panel.x_of(value), bottom + 16, value);
  }
  for (const double value : round_ticks(panel.y, tick_count(panel.height, kPixelsPerTick_y))) {
    text += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}h{:.1f}\"/>", panel.left, panel.y_of(value),
                        panel.width);
    text += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.6g}</text>\n",
                        panel.left - 7, panel.y_of(value) + 4, value);
  }
  text += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>\n",
                      panel.left + panel.width / 2, bottom + 32, escaped(x_name));
  return text + fmt::format("<text class=\"name\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", panel.left,
                            panel.top - 8, escaped(y_name));
}

std::string panel_line(const SvgPanel& panel, const std::vector<double>& x, const std::vector<double>& y) {
  std::string path, last;
  for (std::size_t i = 0; i < x.size(); ++i) {
    std::string point = fmt::format("{:.1f} {:.1f}", panel.x_of(x[i]), panel.y_of(y[i]));
    if (point == last) continue;
    path += (path.empty() ? "M" : "L") + point;
    last = std::move(point);
  }
  return path;
}

}  // namespace uniquadric
