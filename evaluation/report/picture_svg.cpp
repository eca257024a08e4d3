#include <fmt/format.h>

#include "evaluation/report/picture.h"
#include "evaluation/report/svg_colours.h"
#include "evaluation/results/markup.h"

namespace uniquadric {
namespace {

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

const char* class_of(LineKind kind) {
  switch (kind) {
    case LineKind::grid:
      return "grid";
    case LineKind::reference:
      return "reference";
    case LineKind::estimate:
      return "estimate";
    case LineKind::coloured:
      break;
  }
  return "coloured";
}

const char* class_of(TextKind kind) {
  switch (kind) {
    case TextKind::plain:
      return "";
    case TextKind::tick:
      return " class=\"tick\"";
    case TextKind::name:
      return " class=\"name\"";
    case TextKind::title:
      break;
  }
  return " class=\"title\"";
}

const char* name_of(TextAnchor anchor) {
  return anchor == TextAnchor::start    ? ""
         : anchor == TextAnchor::middle ? " text-anchor=\"middle\""
                                        : " text-anchor=\"end\"";
}

std::string svg_of(const PictureLine& line) {
  std::string path;
  for (const auto& [x, y] : line.points)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x, y);
  const std::string colour = line.colour.empty() ? "" : fmt::format(" stroke=\"{}\"", line.colour);
  return fmt::format("<path class=\"{}\"{} d=\"{}\"/>\n", class_of(line.kind), colour, path);
}

std::string svg_of(const PictureText& text) {
  return fmt::format("<text{} x=\"{:.1f}\" y=\"{:.1f}\"{}>{}</text>\n", class_of(text.kind), text.at.x,
                     text.at.y, name_of(text.anchor), escaped(text.text));
}

std::string svg_of(const PictureBox& box) {
  return fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\" fill=\"{}\"/>\n",
                     box.corner.x, box.corner.y, box.width, box.height, box.colour);
}

}  // namespace

std::string picture_svg(const Picture& picture) {
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n",
      picture.width, picture.height, escaped(picture.label));
  text += svg_ground(kRules, colour_rules);
  for (const auto& part : picture.parts) text += std::visit([](const auto& p) { return svg_of(p); }, part);
  return text + "</svg>\n";
}

}  // namespace uniquadric
