#include "evaluation/report/figures.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <limits>
#include <set>

#include "core/base/seconds.h"
#include "evaluation/report/plot_panel.h"
#include "evaluation/report/plots.h"
#include "evaluation/report/svg_colours.h"

namespace uniquadric {
namespace {

constexpr double kWidth = 480, kLeft = 62, kTop = 52, kHeight = 210, kLegendLine = 18;

struct Curve {
  std::string variant;
  std::size_t colour = 0;
  const ObjectSeries* series = nullptr;
};

const std::vector<std::optional<double>>* column_of(const ObjectSeries& series, const char* name) {
  const auto found = name ? series.columns.find(name) : series.columns.end();
  return found == series.columns.end() ? nullptr : &found->second;
}

// A line for each run of frames with a value.
void draw_curve(Picture& picture, const PlotPanel& panel, LineKind kind, const std::string& colour,
                const std::vector<double>& times_s, const std::vector<std::optional<double>>& values) {
  std::vector<double> x, y;
  const auto end_line = [&] {
    if (!x.empty()) picture.parts.emplace_back(PictureLine{kind, panel_line(panel, x, y), colour});
    x.clear();
    y.clear();
  };
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (!values[i]) end_line();
    if (!values[i]) continue;
    x.push_back(times_s[i]);
    y.push_back(*values[i]);
  }
  end_line();
}

std::vector<double> times_s(const ObjectSeries& series, std::int64_t start_ns) {
  std::vector<double> times;
  for (const std::int64_t stamp_ns : series.stamps_ns) times.push_back(seconds(start_ns, stamp_ns));
  return times;
}

std::optional<Picture> picture_of(const Plot& plot, const std::string& where,
                                  const std::vector<Curve>& curves) {
  std::vector<double> values, times;
  std::int64_t start_ns = std::numeric_limits<std::int64_t>::max();
  for (const Curve& curve : curves)
    if (!curve.series->stamps_ns.empty()) start_ns = std::min(start_ns, curve.series->stamps_ns.front());
  for (const Curve& curve : curves)
    for (const char* name : {plot.column, plot.truth})
      if (const auto* column = column_of(*curve.series, name)) {
        for (const auto& value : *column)
          if (value) values.push_back(*value);
        for (const double time : times_s(*curve.series, start_ns)) times.push_back(time);
      }
  if (values.empty()) return std::nullopt;
  const auto [first, last] = std::ranges::minmax(times);
  PlotPanel panel{
      kLeft, kTop, kWidth - kLeft - 20, kHeight, {first, std::max(last, first + 1e-9)}, padded_range(values)};
  if (plot.is_share) panel.y = {0, 1};
  const std::string title = (*plot.unit ? fmt::format("{} [{}]", plot.title, plot.unit) : plot.title) + where;
  const double legend = kTop + kHeight + 48;
  Picture picture{kWidth, legend + kLegendLine * static_cast<double>(curves.size()), title, {}};
  picture.parts.emplace_back(PictureText{TextKind::title, TextAnchor::start, {kLeft, 20}, title});
  draw_axes(picture, panel, "time [s]", "");
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const Curve& curve = curves[i];
    const std::string colour = kLightSvg.variant[curve.colour % kLightSvg.variant.size()];
    const std::vector<double> at = times_s(*curve.series, start_ns);
    if (const auto* truth = column_of(*curve.series, plot.truth); truth && i == 0)
      draw_curve(picture, panel, LineKind::reference, "", at, *truth);
    if (const auto* column = column_of(*curve.series, plot.column))
      draw_curve(picture, panel, LineKind::coloured, colour, at, *column);
    const double y = legend + kLegendLine * static_cast<double>(i);
    picture.parts.emplace_back(
        PictureLine{LineKind::coloured, {{kLeft, y - 4}, {kLeft + 24, y - 4}}, colour});
    picture.parts.emplace_back(
        PictureText{TextKind::plain, TextAnchor::start, {kLeft + 32, y}, curve.variant});
  }
  return picture;
}

// Objects of recordings may have any name.
std::string file_name(const std::string& text) {
  std::string name;
  for (const char c : text)
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ? c : '_';
  return name;
}

}  // namespace

std::vector<Figure> figures_of(const Results& results) {
  const std::vector<std::string> variants = causal_variants_of(results);
  std::vector<Figure> figures;
  std::set<std::string> names;
  for (const std::string& scene : scenes_of(results))
    for (const std::string& object : subjects_of(results, scene)) {
      std::vector<Curve> curves;
      for (std::size_t v = 0; v < variants.size(); ++v)
        for (const Cell& cell : results.cells) {
          if (cell.scene != scene || cell.variant != variants[v] || !cell.evaluation) continue;
          const auto series = std::ranges::find(cell.evaluation->series, object, &ObjectSeries::subject);
          if (series != cell.evaluation->series.end()) curves.push_back({variants[v], v, &*series});
          break;  // its first seed
        }
      for (const Plot& plot : kPlots)
        if (auto picture = picture_of(plot, fmt::format(", {} in {}", object, scene), curves)) {
          std::string name = file_name(fmt::format("{}_{}_{}", scene, object, plot.column));
          while (!names.insert(name).second) name += '_';
          figures.push_back({std::move(name), std::move(*picture)});
        }
    }
  return figures;
}

}  // namespace uniquadric
