#pragma once

#include <string>
#include <variant>
#include <vector>

namespace uniquadric {

/// In the picture's own units, a pixel where it is shown at its size; y downwards.
struct PicturePoint {
  double x = 0, y = 0;
  bool operator==(const PicturePoint&) const = default;
};

/// What a line is of; `coloured` has a colour of its own.
enum class LineKind { grid, reference, estimate, coloured };
struct PictureLine {
  LineKind kind = LineKind::grid;
  std::vector<PicturePoint> points;
  std::string colour;  ///< "#rrggbb"
};

enum class TextKind { plain, tick, name, title };
enum class TextAnchor { start, middle, end };
struct PictureText {
  TextKind kind = TextKind::plain;
  TextAnchor anchor = TextAnchor::start;
  PicturePoint at;  ///< of its base line
  std::string text;
};

struct PictureBox {
  PicturePoint corner;  ///< upper left
  double width = 0, height = 0;
  std::string colour;  ///< "#rrggbb"
};

/// A drawing that does not say how it is written: its parts cover one another in their order.
struct Picture {
  double width = 0, height = 0;
  std::string label;  ///< what it shows, for who cannot see it
  std::vector<std::variant<PictureLine, PictureText, PictureBox>> parts;
};

/// An SVG file's text, for light and dark.
std::string picture_svg(const Picture& picture);

/// A PDF file's bytes, its text as text: in the light colours.
std::string picture_pdf(const Picture& picture);

/// A PNG file's bytes: in the light colours, two pixels a unit.
std::string picture_png(const Picture& picture);

}  // namespace uniquadric
