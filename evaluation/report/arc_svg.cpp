#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "evaluation/report/arc_curves.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/results/markup.h"
#include "evaluation/results/summary.h"
#include "evaluation/view_arc.h"

namespace uniquadric {
namespace {

// Sizes in the picture's own units, a pixel where it is shown at its size.
constexpr double kPanelWidth = 460, kPanelHeight = 270;  // with its margins
constexpr double kLeft = 46, kRight = 24, kTop = 34, kBottom = 42;
constexpr double kPlotWidth = kPanelWidth - kLeft - kRight, kPlotHeight = kPanelHeight - kTop - kBottom;
constexpr int kColumns = 2;
constexpr double kMargin = 8, kLegendLine = 22, kLegendSample = 26, kLetter = 7.4;
constexpr double kStep_deg = 5, kMost_deg = 180;

constexpr std::size_t kColours = kLightSvg.variant.size();

// Written out a rule each: some viewers of pictures know no variables of CSS.
std::string colour_rules(const SvgColours& colours) {
  std::string text = fmt::format(
      ".arc text{{fill:{1}}}.arc .back{{fill:{0}}}.arc .tick{{fill:{2}}}.arc .wide{{stroke:{2}}}"
      ".arc .grid{{stroke:{3}}}\n",
      colours.back, colours.text, colours.quiet, colours.grid);
  for (std::size_t i = 0; i < kColours; ++i)
    text += fmt::format(".arc .s{0}{{stroke:{1}}}.arc .f{0}{{fill:{1}}}\n", i, colours.variant[i]);
  return text;
}

const char* const kRules =
    ".arc text{font:12px system-ui,\"Segoe UI\",\"DejaVu Sans\",sans-serif}\n"
    ".arc .tick{font-size:11px;font-weight:400}\n.arc .title{font-weight:600}\n"
    ".arc .grid{fill:none}.arc .wide{stroke-dasharray:3 4}\n"
    ".arc .median{fill:none;stroke-width:2;stroke-linejoin:round}.arc .band{stroke:none;opacity:.18}\n";

std::vector<double> edges() {
  std::vector<double> list;
  for (double edge = 0; edge <= kMost_deg; edge += kStep_deg) list.push_back(edge);
  return list;
}

double x_of(double arc_deg) {
  return kLeft + kPlotWidth * arc_deg / kMost_deg;
}

double y_of(double iou) {
  return kTop + kPlotHeight * (1 - iou);
}

double middle_x(const ArcPoint& point) {
  return x_of((point.from_deg + point.to_deg) / 2);
}

std::string axes() {
  std::string text;
  for (int i = 0; i <= 5; ++i) {
    const double iou = i / 5.0;
    text += fmt::format("<path class=\"grid\" d=\"M{:.1f} {:.1f}h{:.1f}\"/>", kLeft, y_of(iou), kPlotWidth);
    text += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{:.1f}</text>\n",
                        kLeft - 7, y_of(iou) + 4, iou);
  }
  for (int arc = 0; arc <= kMost_deg; arc += 30)
    text += fmt::format("<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}°</text>\n",
                        x_of(arc), kTop + kPlotHeight + 16, arc);
  text += fmt::format(
      "<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">arc of views</text>\n",
      kLeft + kPlotWidth / 2, kTop + kPlotHeight + 33);
  text += fmt::format(
      "<text class=\"tick\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">IoU of ellipsoids</text>\n",
      kLeft + kPlotWidth, kTop - 12);
  return text + fmt::format("<path class=\"wide\" d=\"M{:.1f} {:.1f}v{:.1f}\"/>\n", x_of(kWideArc_deg), kTop,
                            kPlotHeight);
}

// There along the greatest and back along the least.
std::string band(const ArcCurve& curve, std::size_t colour) {
  std::string path;
  for (const ArcPoint& point : curve.points)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", middle_x(point), y_of(point.max));
  for (auto point = curve.points.rbegin(); point != curve.points.rend(); ++point)
    path += fmt::format("L{:.1f} {:.1f}", middle_x(*point), y_of(point->min));
  return fmt::format("<path class=\"band f{}\" d=\"{}Z\"/>\n", colour, path);
}

std::string median_line(const ArcCurve& curve, std::size_t colour) {
  std::string path;
  for (const ArcPoint& point : curve.points)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", middle_x(point), y_of(point.median));
  const double only = curve.points.size() == 1 ? 4 : 0;  // a point alone would not be seen
  if (only > 0) path += fmt::format("h{:.1f}", only);
  return fmt::format("<path class=\"median s{}\" d=\"{}\"><title>{}</title></path>\n", colour, path,
                     escaped(curve.variant));
}

// Curves by variant, a variant's colour being that of its place among all.
std::string panel(std::span<const ArcCurve> curves, const std::vector<std::string>& variants) {
  std::string text = fmt::format(
      "<text class=\"title\" x=\"{:.1f}\" y=\"{:.1f}\">{} <tspan class=\"tick\">{}</tspan></text>\n", kLeft,
      kTop - 12, escaped(curves.front().object), escaped(curves.front().scene));
  text += axes();
  std::string bands, lines;
  for (const ArcCurve& curve : curves) {
    const auto place = std::find(variants.begin(), variants.end(), curve.variant) - variants.begin();
    const std::size_t colour = static_cast<std::size_t>(place) % kColours;
    bands += band(curve, colour);
    lines += median_line(curve, colour);
  }
  return text + bands + lines;
}

struct Legend {
  std::string text;
  double height = 0;
};

Legend legend(const std::vector<std::string>& variants, double width) {
  Legend result;
  double x = kLeft, y = kMargin + 14;
  for (std::size_t i = 0; i < variants.size(); ++i) {
    const double needed = kLegendSample + 8 + kLetter * static_cast<double>(variants[i].size()) + 18;
    if (x > kLeft && x + needed > width) x = kLeft, y += kLegendLine;
    result.text += fmt::format("<path class=\"median s{}\" d=\"M{:.1f} {:.1f}h{:.1f}\"/>", i % kColours, x,
                               y - 4, kLegendSample);
    result.text += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + kLegendSample + 8, y,
                               escaped(variants[i]));
    x += needed;
  }
  result.height = y + 6;
  return result;
}

// Of what was known at each frame: a later output's curve says less, one of the end nothing.
std::vector<ArcCurve> drawn_curves(const Results& results) {
  std::vector<ArcCurve> curves = arc_curves(results, edges());
  std::erase_if(curves, [](const ArcCurve& curve) { return !output_of(curve.variant).empty(); });
  return curves;
}

std::string svg_start(const char* attributes, double width, double height, const char* label) {
  return fmt::format(
      "<svg class=\"arc\"{0} viewBox=\"0 0 {1:.0f} {2:.0f}\" width=\"{1:.0f}\" height=\"{2:.0f}\" "
      "role=\"img\" "
      "aria-label=\"{3}\">\n",
      attributes, width, height, label);
}

// One after the other where scene and object change.
std::vector<std::span<const ArcCurve>> panels_of(const std::vector<ArcCurve>& curves) {
  std::vector<std::span<const ArcCurve>> panels;
  for (std::size_t begin = 0, i = 1; i <= curves.size(); ++i) {
    const bool same = i < curves.size() && curves[i].scene == curves[begin].scene &&
                      curves[i].object == curves[begin].object;
    if (same) continue;
    panels.push_back(std::span(curves).subspan(begin, i - begin));
    begin = i;
  }
  return panels;
}

}  // namespace

std::string arc_svg(const Results& results) {
  const std::vector<ArcCurve> curves = drawn_curves(results);
  if (curves.empty()) return "";
  const auto panels = panels_of(curves);
  const std::vector<std::string> variants = causal_variants_of(results);
  const double columns = std::min<double>(kColumns, static_cast<double>(panels.size()));
  const double rows = std::ceil(static_cast<double>(panels.size()) / columns);
  const double width = columns * kPanelWidth;
  const Legend head = legend(variants, width);
  const double height = head.height + rows * kPanelHeight + kMargin;
  std::string text = svg_start(" xmlns=\"http://www.w3.org/2000/svg\"", width, height,
                               "IoU of each object's ellipsoid against the arc of views");
  text += svg_ground(kRules, colour_rules) + head.text;
  for (std::size_t i = 0; i < panels.size(); ++i)
    text += fmt::format("<g transform=\"translate({:.1f} {:.1f})\">\n{}</g>\n",
                        kPanelWidth * static_cast<double>(i % kColumns),
                        head.height + kPanelHeight * static_cast<double>(i / kColumns),
                        panel(panels[i], variants));
  return text + "</svg>\n";
}

std::string arc_html(const Results& results) {
  const std::vector<ArcCurve> curves = drawn_curves(results);
  if (curves.empty()) return "";
  const std::vector<std::string> variants = causal_variants_of(results);
  std::string text = svg_style(kRules, colour_rules) + "<p class=\"arc-legend\">";
  for (std::size_t i = 0; i < variants.size(); ++i)
    text += fmt::format(
        "<span><svg class=\"arc\" width=\"26\" height=\"8\" aria-hidden=\"true\"><path class=\"median "
        "s{}\" d=\"M0 4h26\"/></svg>{}</span>\n",
        i % kColours, escaped(variants[i]));
  text += "</p>\n<div class=\"arcs\">\n";
  for (const auto& of_object : panels_of(curves))
    text +=
        svg_start("", kPanelWidth, kPanelHeight, "IoU of an object's ellipsoid against the arc of views") +
        panel(of_object, variants) + "</svg>\n";
  return text + "</div>";
}

}  // namespace uniquadric
