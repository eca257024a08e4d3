#include "evaluation/report/figures.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <iterator>
#include <limits>
#include <map>
#include <set>

#include "core/base/seconds.h"
#include "evaluation/report/plot_panel.h"
#include "evaluation/report/plots.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/report/variant_figures.h"

namespace uniquadric {
namespace {

constexpr std::size_t kMostName = 200;  // bytes: file systems take 255 with the ending
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

std::vector<NamedPicture> figures_over_time(const Results& results) {
  const std::vector<std::string> variants = causal_variants_of(results);
  std::vector<NamedPicture> figures;
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
        if (auto picture = picture_of(plot, fmt::format(", {} in {}", object, scene), curves))
          figures.push_back({figure_name({scene, object, plot.column}), std::move(*picture)});
    }
  return figures;
}

struct ErrorCurve {
  std::vector<double> errors_m, shares;  // middles of cells, points in them [%]
};

ErrorCurve error_curve(const LidarRoutes& routes) {
  ErrorCurve curve;
  const double points = static_cast<double>(std::max<std::int64_t>(1, routes.matched));
  for (const ErrorCell& cell : routes.errors) {
    if (!std::isfinite(cell.from_m) || !std::isfinite(cell.to_m)) continue;  // the outer two
    curve.errors_m.push_back((cell.from_m + cell.to_m) / 2);
    curve.shares.push_back(100 * static_cast<double>(cell.beams) / points);
  }
  return curve;
}

Picture range_errors(const std::string& scene, const std::vector<ErrorCurve>& seeds) {
  std::vector<double> errors_m, shares;
  for (const ErrorCurve& curve : seeds) {
    errors_m.insert(errors_m.end(), curve.errors_m.begin(), curve.errors_m.end());
    shares.insert(shares.end(), curve.shares.begin(), curve.shares.end());
  }
  const PlotPanel panel{
      kLeft, kTop, kWidth - kLeft - 20, kHeight, padded_range(errors_m), padded_range(shares)};
  const std::string title = fmt::format("Range errors in {}", scene);
  Picture picture{kWidth, kTop + kHeight + 40, title, {}};
  picture.parts.emplace_back(PictureText{TextKind::title, TextAnchor::start, {kLeft, 20}, title});
  draw_axes(picture, panel, "error [m]", "points [%]");
  for (std::size_t i = 0; i < seeds.size(); ++i)
    picture.parts.emplace_back(PictureLine{LineKind::coloured,
                                           panel_line(panel, seeds[i].errors_m, seeds[i].shares),
                                           kLightSvg.variant[i % kLightSvg.variant.size()]});
  return picture;
}

std::vector<NamedPicture> range_error_figures(const Results& results) {
  std::map<std::string, std::vector<ErrorCurve>> scenes;
  for (const LidarRoutes& routes : results.lidar)
    if (!routes.errors.empty()) scenes[routes.scene].push_back(error_curve(routes));
  std::vector<NamedPicture> figures;
  for (const auto& [scene, seeds] : scenes)
    figures.push_back({figure_name({scene, "range_error"}), range_errors(scene, seeds)});
  return figures;
}

}  // namespace

std::string figure_name(std::initializer_list<std::string> parts) {
  std::string name;
  for (const char c : fmt::format("{}", fmt::join(parts, "_")))
    name += std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ? c : '_';
  return name.substr(0, kMostName);
}

std::vector<NamedPicture> figures_of(const Results& results, const std::vector<SummaryRow>& summary) {
  std::vector<NamedPicture> figures = figures_over_time(results);
  std::ranges::move(variant_figures(results, summary), std::back_inserter(figures));
  std::ranges::move(range_error_figures(results), std::back_inserter(figures));
  std::set<std::string> names;
  for (NamedPicture& figure : figures)
    while (!names.insert(figure.name).second) figure.name += '_';
  return figures;
}

}  // namespace uniquadric
