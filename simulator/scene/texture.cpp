#include "simulator/scene/texture.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <string>
#include <vector>

#include "simulator/scene/painter.h"

namespace uniquadric {
namespace {

void fill_rect(Painter& p, const cv::Rect& rect, const Color& color) {
  cv::rectangle(p.image, rect, color, cv::FILLED);
}

// A rectangle split at random until its parts are a few marks wide, each a painted panel with a dark seam.
void add_panels(Painter& p, const cv::Rect& rect) {
  const int least = 2 * p.unit;
  const bool wide = rect.width > rect.height;
  const int side = std::max(rect.width, rect.height);
  if (side > 3 * least && (side > 6 * least || p.random.uniform() < 0.7)) {
    const int cut = static_cast<int>(side * p.random.uniform(0.3, 0.7));
    add_panels(p,
               wide ? cv::Rect(rect.x, rect.y, cut, rect.height) : cv::Rect(rect.x, rect.y, rect.width, cut));
    add_panels(p, wide ? cv::Rect(rect.x + cut, rect.y, rect.width - cut, rect.height)
                       : cv::Rect(rect.x, rect.y + cut, rect.width, rect.height - cut));
    return;
  }
  fill_rect(p, rect, p.tone());
  cv::rectangle(p.image, rect, p.shade(p.material.color, 0.3), std::max(1, p.unit / 12));
}

void add_checks(Painter& p) {
  const int side = 2 * p.unit;
  for (int i = 0; i * side < p.image.rows; ++i)
    for (int j = 0; j * side < p.image.cols; ++j) {
      const Eigen::Vector3d& base = (i + j) % 2 == 0 ? p.material.color : p.material.accent;
      fill_rect(p, {j * side, i * side, side, side},
                p.shade(base, 1 + p.material.contrast * p.random.uniform(-0.5, 0.5)));
    }
}

// Rows of boards or bricks, each row shifted by its own amount.
void add_courses(Painter& p, int height, double shortest, double longest) {
  for (int y = 0; y < p.image.rows; y += height)
    for (int x = -p.length(0.5, 6); x < p.image.cols;) {
      const int width = p.length(shortest, longest);
      const cv::Rect course(x, y, width, height);
      fill_rect(p, course, p.tone());
      cv::rectangle(p.image, course, p.shade(p.material.color, 0.35), std::max(1, p.unit / 10));
      x += width;
    }
}

void add_speckle(Painter& p, double per_square_unit) {
  for (int k = p.count(per_square_unit); k > 0; --k) {
    const cv::Point centre = p.place();
    const cv::Size axes{p.length(0.06, 0.5), p.length(0.06, 0.5)};
    const double tilt_deg = p.random.uniform(0, 180);
    cv::ellipse(p.image, centre, axes, tilt_deg, 0, 360, p.ink(), cv::FILLED, cv::LINE_AA);
  }
}

// Letters, bars and corners as on signs and crates: the corners that trackers like best.
void add_strokes(Painter& p, double per_square_unit) {
  static const std::string kGlyphs = "ABCDEFGHKLMNPQRSTUVWXYZ23456789#%&+=?";
  for (int k = p.count(per_square_unit); k > 0; --k) {
    const cv::Point at = p.place();
    const Color color = p.ink();
    const int size = p.length(0.4, 2.5);
    const double kind = p.random.uniform();
    if (kind < 0.5) {
      std::string word;
      for (auto letters = 1 + p.random.below(4); letters > 0; --letters)
        word += kGlyphs[p.random.below(static_cast<std::uint32_t>(kGlyphs.size()))];
      cv::putText(p.image, word, at, cv::FONT_HERSHEY_DUPLEX, size / 22.0, color, std::max(1, size / 9),
                  cv::LINE_AA);
    } else if (kind < 0.8) {
      fill_rect(p, {at, cv::Size(size, std::max(2, p.length(0.1, 1)))}, color);
    } else {
      std::vector<cv::Point> corners;
      for (int c = 0; c < 3; ++c) corners.push_back(at + cv::Point{p.length(0.2, 2), p.length(0.2, 2)});
      cv::fillConvexPoly(p.image, corners, color, cv::LINE_AA);
    }
  }
}

void add_style(Painter& p) {
  const cv::Rect whole({0, 0}, p.image.size());
  const double share = p.material.amount == TextureAmount::rich ? 1 : 0.125;
  switch (p.material.style) {
    case TextureStyle::panels:
      return add_panels(p, whole);
    case TextureStyle::checks:
      return add_checks(p);
    case TextureStyle::speckle:
      return add_speckle(p, 3 * share);
    case TextureStyle::strokes:
      return add_strokes(p, share);
    case TextureStyle::planks:
      return add_courses(p, std::max(2, p.unit * 3 / 2), 4, 14);
    case TextureStyle::bricks:
      return add_courses(p, std::max(2, p.unit), 1.5, 3);
  }
}

}  // namespace

cv::Mat paint_texture(const Material& material, std::uint32_t part, double width_m, double height_m) {
  const double long_side_m = std::max(width_m, height_m);
  const auto side_px = [&](double side_m) {
    return std::max(16, static_cast<int>(std::lround(material.size_px * side_m / long_side_m)));
  };
  Painter p{material,
            RandomStream(material.seed, "texture", part),
            {},
            std::max(4, material.size_px / material.marks)};
  // Each part leans to its own tone, so that one side is told from another.
  const double gain = 1 + 0.35 * material.contrast * p.random.uniform(-1, 1);
  p.image = cv::Mat(side_px(height_m), side_px(width_m), CV_8UC3, p.shade(material.color, gain));
  if (!material.is_painted || material.amount == TextureAmount::none) return p.image;
  add_style(p);
  if (material.amount == TextureAmount::rich) {
    add_strokes(p, 0.12);
    add_speckle(p, 0.5);
  }
  add_value_noise(p);
  return p.image;
}

}  // namespace uniquadric
