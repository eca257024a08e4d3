#pragma once

#include <array>
#include <optional>
#include <string>

namespace uniquadric {

/// The page's colours (page/data.js, page.css), which keep apart for the colour-blind, for pictures of their
/// own.
struct SvgColours {
  std::array<const char*, 8> variant;
  const char *back, *text, *quiet, *grid;
};
inline constexpr SvgColours kLightSvg = {
    {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a6d00", "#56a3d9", "#7a3db8", "#5c6670"},
    "#ffffff",
    "#1d2126",
    "#5c6670",
    "#e2dfd9"};
inline constexpr SvgColours kDarkSvg = {
    {"#4aa8e8", "#ff8f3f", "#35cfa0", "#e89ac4", "#e8d24a", "#8cccf5", "#b98aef", "#a5adb5"},
    "#1c2024",
    "#e8e6e3",
    "#9aa3ac",
    "#2f353b"};

struct Rgb {
  int red = 0, green = 0, blue = 0;  ///< 0 to 255
};
/// The colour of "#rrggbb"; nothing of any other text.
std::optional<Rgb> rgb_of(const std::string& hex);

/// A picture's style: `rules`, and `colour_rules` of the light colours, of the dark ones where those are
/// preferred.
inline std::string svg_style(const char* rules, std::string (*colour_rules)(const SvgColours&)) {
  return std::string("<style>\n") + rules + colour_rules(kLightSvg) +
         "@media (prefers-color-scheme:dark){\n" + colour_rules(kDarkSvg) + "}\n</style>\n";
}

/// Style and background.
inline std::string svg_ground(const char* rules, std::string (*colour_rules)(const SvgColours&)) {
  return svg_style(rules, colour_rules) + "<rect class=\"back\" width=\"100%\" height=\"100%\"/>\n";
}

}  // namespace uniquadric
