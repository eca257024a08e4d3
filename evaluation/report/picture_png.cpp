#include <cmath>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/sequence/image_file.h"
#include "evaluation/report/picture.h"
#include "evaluation/report/svg_colours.h"

namespace uniquadric {
namespace {

constexpr double kScale = 2;             // pixels a unit: small type is legible from there on
constexpr int kShift = 4;                // of the fixed-point corners that lines are drawn by
constexpr double kDash = 3, kPause = 5;  // as 5 and 3 in the SVG: lines end round here, a unit further
constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kFontSize = 0.41;  // 12 units high, as the type of the SVG

cv::Scalar colour_of(const std::string& hex) {
  const Rgb rgb = rgb_of(hex).value();
  return cv::Scalar(rgb.blue, rgb.green, rgb.red);
}

cv::Point fixed_point(const PicturePoint& point) {
  // a pixel's middle is a whole number here, its border in the picture
  const auto fixed = [](double x) {
    return static_cast<int>(std::lround((kScale * x - 0.5) * (1 << kShift)));
  };
  return {fixed(point.x), fixed(point.y)};
}

using Way = std::vector<PicturePoint>;

// The dashes of a way, counted from its start through its corners.
std::vector<Way> dashes(const Way& way) {
  std::vector<Way> result = {{way.front()}};
  bool drawn = true;
  double left = kDash;
  for (std::size_t i = 1; i < way.size(); ++i) {
    PicturePoint at = way[i - 1];
    for (double length; (length = std::hypot(way[i].x - at.x, way[i].y - at.y)) > left;) {
      at = {at.x + (way[i].x - at.x) * left / length, at.y + (way[i].y - at.y) * left / length};
      if (drawn)
        result.back().push_back(at);
      else
        result.push_back({at});
      drawn = !drawn;
      left = drawn ? kDash : kPause;
    }
    left -= std::hypot(way[i].x - at.x, way[i].y - at.y);
    if (drawn) result.back().push_back(way[i]);
  }
  return result;
}

void draw_ways(cv::Mat& image, const std::vector<Way>& ways, const cv::Scalar& colour, int width_px) {
  std::vector<std::vector<cv::Point>> lines;
  for (const Way& way : ways) {
    lines.emplace_back();
    for (const PicturePoint& point : way) lines.back().push_back(fixed_point(point));
  }
  cv::polylines(image, lines, false, colour, width_px, cv::LINE_AA, kShift);
}

void draw(cv::Mat& image, const PictureLine& line) {
  if (line.points.empty()) return;
  switch (line.kind) {  // widths in pixels: smoothed edges add one to them
    case LineKind::grid:
      return draw_ways(image, {line.points}, colour_of(kLightSvg.grid), 1);
    case LineKind::reference:
      return draw_ways(image, dashes(line.points), colour_of(kLightSvg.quiet), 2);
    case LineKind::estimate:
      return draw_ways(image, {line.points}, colour_of(kLightSvg.variant[0]), 2);
    case LineKind::coloured:
      return draw_ways(image, {line.points}, colour_of(line.colour), 3);
  }
}

void draw(cv::Mat& image, const PictureText& text) {
  const bool is_tick = text.kind == TextKind::tick;
  const bool is_heavy = text.kind == TextKind::name || text.kind == TextKind::title;
  const double size = kScale * kFontSize * (is_tick ? 11.0 / 12 : 1);
  const int width_px = is_heavy ? 2 : 1;
  int below = 0;
  const int length = cv::getTextSize(text.text, kFont, size, width_px, &below).width;
  const double x = kScale * text.at.x - (text.anchor == TextAnchor::start    ? 0
                                         : text.anchor == TextAnchor::middle ? length / 2.0
                                                                             : length);
  cv::putText(image, text.text, cv::Point(cvRound(x), cvRound(kScale * text.at.y)), kFont, size,
              colour_of(is_tick ? kLightSvg.quiet : kLightSvg.text), width_px, cv::LINE_AA);
}

void draw(cv::Mat& image, const PictureBox& box) {
  const auto at = [](double x) { return cvRound(kScale * x); };
  const cv::Point corner(at(box.corner.x), at(box.corner.y));
  const cv::Point end(at(box.corner.x + box.width), at(box.corner.y + box.height));
  cv::rectangle(image, cv::Rect(corner, end), colour_of(box.colour), cv::FILLED);
}

}  // namespace

std::string picture_png(const Picture& picture) {
  cv::Mat image(cvRound(kScale * picture.height), cvRound(kScale * picture.width), CV_8UC3,
                colour_of(kLightSvg.back));
  for (const auto& part : picture.parts) std::visit([&](const auto& p) { draw(image, p); }, part);
  return encode_image(".png", image, {cv::IMWRITE_PNG_COMPRESSION, 9}, "picture");
}

}  // namespace uniquadric
