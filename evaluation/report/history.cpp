#include "evaluation/report/history.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "core/base/error.h"
#include "evaluation/comparison/comparison_table.h"
#include "evaluation/comparison/score_comparison.h"
#include "evaluation/report/page_assets.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/results/markup.h"
#include "evaluation/results/summary.h"

namespace uniquadric {
namespace {
namespace fs = std::filesystem;

using Figures = std::map<std::pair<std::string, std::string>, double>;  // by variant and metric

struct Point {
  std::string name;
  std::vector<std::string> variants;  // in the order of the report's, which has their colours
  Figures figures;
  std::string answer, headline;  // against the one before
};

std::string name_of(const Results& results) {
  const std::size_t commit = results.program.find("commit ");
  if (commit == std::string::npos)  // the folder's, also where it was given with a slash at its end
    return (results.folder / "").parent_path().filename().string();
  const std::string name = results.program.substr(commit + 7, 8);
  return results.program.find(", changed", commit) == std::string::npos ? name : name + " (changed)";
}

Point point_of(const fs::path& folder) {
  Point point{"", {}, {}, "", "the first"};
  OverallRows all;
  for_each_scene(folder, [&](const Results& scene) {
    point.name = name_of(scene);
    for (const auto* const cells : {&scene.cells, &scene.not_applicable})
      for (const Cell& cell : *cells) add_distinct(point.variants, cell.variant);
    all.add(summarize(scene));
  });
  for (const SummaryRow& row : all.rows("all"))
    for (const char* metric : summary_metrics())
      if (const auto found = row.spread.find(metric); found != row.spread.end())
        point.figures[{row.variant, metric}] = found->second.median;
  return point;
}

std::vector<Point> points_of(const std::vector<fs::path>& folders) {
  std::vector<Point> points;
  std::optional<ScoreTable> before;
  for (const fs::path& folder : folders) {
    Point point = point_of(folder);
    ScoreTable now = read_score_table(folder);
    leave_out_parts(now);
    if (before) {
      const ScoreComparison comparison = compare_scores(*before, now);
      point.answer = to_string(comparison.answer), point.headline = headline(comparison);
    }
    before = std::move(now);
    points.push_back(std::move(point));
  }
  return points;
}

// Variants and metrics that any point has, in their order.
std::vector<std::pair<std::string, std::string>> keys_of(const std::vector<Point>& points) {
  std::vector<std::pair<std::string, std::string>> keys;
  Figures all;
  for (const Point& point : points) all.insert(point.figures.begin(), point.figures.end());
  for (const char* metric : summary_metrics())
    for (const auto& [key, value] : all)
      if (key.second == metric) keys.push_back(key);
  return keys;
}

std::optional<double> figure_of(const Point& point, const std::pair<std::string, std::string>& key) {
  const auto found = point.figures.find(key);
  return found == point.figures.end() ? std::nullopt : std::optional(found->second);
}

std::string text_of(const std::vector<Point>& points) {
  std::vector<std::vector<std::string>> lines = {{"variant", "metric"}};
  std::string sides = "<<";
  for (const Point& point : points) lines[0].push_back(point.name), sides += '>';
  for (const auto& key : keys_of(points)) {
    std::vector<std::string> line = {key.first, label_with_unit(find_metric(key.second))};
    for (const Point& point : points) {
      const auto value = figure_of(point, key);
      line.push_back(value ? format_figure(*value) : "-");
    }
    lines.push_back(line);
  }
  std::string text = aligned_columns(lines, sides) + "\n";
  for (const Point& point : points) text += fmt::format("{}: {}\n", point.name, point.headline);
  return text;
}

// As in the report: a variant has one colour, its later outputs have dashes.
std::size_t colour_of(const std::vector<std::string>& variants, std::size_t variant) {
  std::vector<std::string_view> names;
  for (std::size_t v = 0; v <= variant; ++v)
    if (std::ranges::find(names, without_output(variants[v])) == names.end())
      names.push_back(without_output(variants[v]));
  const auto place = std::ranges::find(names, without_output(variants[variant])) - names.begin();
  return static_cast<std::size_t>(place) % kLightSvg.variant.size();
}

const char* dashes_of(const std::string& variant) {
  const std::string output = output_of(variant);
  return output.empty() ? "" : output == "@final" ? " stroke-dasharray=\"2 3\"" : " stroke-dasharray=\"7 3\"";
}

// A curve a variant over the points; the best end of the axis is named.
constexpr double kWidth = 420, kHeight = 150, kLeft = 56, kRight = 12, kTop = 26, kBottom = 26;

std::string curves_of(const std::vector<Point>& points, const std::string& metric,
                      const std::vector<std::string>& variants) {
  double least = 1e300, most = -1e300;
  for (const Point& point : points)
    for (const auto& [key, value] : point.figures)
      if (key.second == metric) least = std::min(least, value), most = std::max(most, value);
  const double margin = most > least ? 0.08 * (most - least) : 0.05 * std::abs(most) + 1e-12;
  const auto x_of = [&](std::size_t i) {
    return kLeft +
           (kWidth - kLeft - kRight) * static_cast<double>(i) / static_cast<double>(points.size() - 1);
  };
  const auto y_of = [&](double value) {
    return kTop + (kHeight - kTop - kBottom) * (most + margin - value) / (most - least + 2 * margin);
  };
  std::string text = fmt::format(
      "<svg viewBox=\"0 0 {0} {1}\" role=\"img\" aria-label=\"{2} over the commits\"><text x=\"{3}\" "
      "y=\"15\" "
      "class=\"t\">{2}</text>",
      kWidth, kHeight, escaped(label_with_unit(find_metric(metric))), kLeft);
  for (const double value : {least, most})
    text += fmt::format(
        "<path class=\"g\" d=\"M{} {:.1f}H{}\"/><text x=\"{}\" y=\"{:.1f}\" class=\"v\">{}</text>", kLeft,
        y_of(value), kWidth - kRight, kLeft - 6, y_of(value) + 4, format_figure(value));
  for (std::size_t v = 0; v < variants.size(); ++v) {
    std::string path;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (const auto value = figure_of(points[i], {variants[v], metric}); value) {
        path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_of(i), y_of(*value));
        text += fmt::format(
            "<circle class=\"f{}\" cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"3\"><title>{}, {}: {}</title></circle>",
            colour_of(variants, v), x_of(i), y_of(*value), escaped(points[i].name), escaped(variants[v]),
            format_figure(*value));
      }
    text +=
        fmt::format("<path class=\"s{}\"{} d=\"{}\"/>", colour_of(variants, v), dashes_of(variants[v]), path);
  }
  return text + "</svg>\n";
}

std::string colour_rules(const SvgColours& colours) {
  std::string text;
  for (std::size_t i = 0; i < colours.variant.size(); ++i)
    text += fmt::format(".h .s{0}{{stroke:{1}}}.h .f{0}{{fill:{1};background:{1}}}\n", i, colours.variant[i]);
  return text;
}

std::string html_of(const std::vector<Point>& points) {
  std::vector<std::string> variants = points.back().variants;
  for (const Point& point : points)
    for (const std::string& variant : point.variants) add_distinct(variants, variant);
  std::string text = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
      "content=\"width=device-width, initial-scale=1\"><meta http-equiv=\"Content-Security-Policy\" "
      "content=\"default-src 'none'; style-src 'unsafe-inline'\"><title>History · "
      "uniquadric</title>\n<style>\n{}</style>\n{}"
      "</head><body class=\"h\"><main>\n<h1>{} commits</h1>\n<p>Medians over the objects of all scenes, each "
      "over its seeds; oldest "
      "first. The gate compares each with the one before. Dashes: what was known some time later (long) and "
      "at the end (short).</p>\n<p>",
      page_asset("page.css"),
      svg_style(".h svg{width:420px;max-width:100%}.h path{fill:none;stroke-width:2}.h "
                ".g{stroke:currentColor;opacity:.2;stroke-"
                "width:1}.h text{fill:currentColor;font-size:12px}.h .v{text-anchor:end;font-size:10px}.h "
                "i{display:inline-"
                "block;width:.7em;height:.7em;margin:0 .4em 0 1em}\n",
                colour_rules),
      points.size());
  for (std::size_t v = 0; v < variants.size(); ++v)
    if (output_of(variants[v]).empty())
      text += fmt::format("<i class=\"f{}\"></i>{}", colour_of(variants, v), escaped(variants[v]));
  text += "</p>\n<div>\n";
  for (const char* metric : summary_metrics())
    if (std::any_of(points.begin(), points.end(), [&](const Point& point) {
          return std::any_of(point.figures.begin(), point.figures.end(),
                             [&](const auto& figure) { return figure.first.second == metric; });
        }))
      text += curves_of(points, metric, variants);
  text +=
      "</div>\n<div class=\"scroll\"><table><thead><tr><th>commit</th><th>against the one "
      "before</th><th>why</th></tr></thead><tbody>\n";
  for (const Point& point : points)
    text += fmt::format("<tr><td><code>{}</code></td><td class=\"{}\">{}</td><td>{}</td></tr>\n",
                        escaped(point.name),
                        point.answer == "pass"    ? "gain"
                        : point.answer == "worse" ? "loss"
                                                  : "",
                        escaped(point.answer), escaped(point.headline));
  return text + "</tbody></table></div>\n</main></body></html>\n";
}

}  // namespace

History history(const std::vector<fs::path>& folders) {
  if (folders.size() < 2) throw InputError("history needs two results folders at least");
  const std::vector<Point> points = points_of(folders);
  return {text_of(points), html_of(points)};
}

}  // namespace uniquadric
