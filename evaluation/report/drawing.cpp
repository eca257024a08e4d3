#include "evaluation/report/drawing.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

namespace uniquadric {
namespace {

const cv::Scalar kBlack(0, 0, 0);
constexpr double kTint = 0.35;  // ours: the surface stays visible

// Blue, magenta, cyan, ...: neither the green of the truth nor the orange of the estimate.
const cv::Vec3b kIdColors[] = {{255, 120, 60}, {220, 60, 200}, {230, 210, 40},
                               {200, 90, 120}, {120, 60, 250}, {255, 200, 160}};

constexpr int kShift = 4;  // OpenCV's fixed point: sixteenths of a pixel

// Nothing beyond what the fixed point holds.
std::optional<cv::Point> fixed_point(const Canvas& canvas, const Eigen::Vector2d& pixel) {
  const cv::Point2d q = canvas.at(pixel) * (1 << kShift);
  if (!(std::abs(q.x) < 1e8 && std::abs(q.y) < 1e8)) return std::nullopt;
  return cv::Point(static_cast<int>(std::lround(q.x)), static_cast<int>(std::lround(q.y)));
}

// A straight edge in space, in pieces: the lens bends it.
void draw_edge(Canvas& canvas, const Eigen::Vector3d& from, const Eigen::Vector3d& to,
               const cv::Scalar& color, int line_px) {
  constexpr int kPieces = 16;
  constexpr double kNearest_m = 0.05;
  std::optional<cv::Point> last;
  for (int i = 0; i <= kPieces; ++i) {
    const Eigen::Vector3d point = from + (to - from) * i / kPieces;
    const auto pixel = point.z() < kNearest_m ? std::nullopt : canvas.camera.project(point);
    const auto here = pixel ? fixed_point(canvas, *pixel) : std::nullopt;
    if (last && here) cv::line(canvas.image, *last, *here, color, line_px, cv::LINE_AA, kShift);
    last = here;
  }
}

std::vector<Eigen::Vector2d> rectangle_corners(const Ellipse& e) {
  const Eigen::Rotation2Dd rotation(e.angle_rad);
  std::vector<Eigen::Vector2d> corners;
  for (const Eigen::Vector2d& sign : {Eigen::Vector2d(-1, -1), {1, -1}, {1, 1}, {-1, 1}})
    corners.push_back(e.center + rotation * sign.cwiseProduct(Eigen::Vector2d(e.semi_major, e.semi_minor)));
  return corners;
}

// A polygon with its sides cut into pieces, which a lens can bend.
std::vector<Eigen::Vector2d> cut_sides(const std::vector<Eigen::Vector2d>& corners) {
  constexpr double kPiece_px = 10, kMostPieces = 100;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const Eigen::Vector2d side = corners[(i + 1) % corners.size()] - corners[i];
    const int pieces = static_cast<int>(std::clamp(std::ceil(side.norm() / kPiece_px), 1.0, kMostPieces));
    for (int k = 0; k < pieces; ++k) points.push_back(corners[i] + side * k / pieces);
  }
  return points;
}

}  // namespace

cv::Point2d Canvas::at(const Eigen::Vector2d& pixel) const {
  return {(pixel.x() + 0.5) * scale - 0.5, (pixel.y() + 0.5) * scale - 0.5};
}

Canvas make_canvas(const cv::Mat& image, const Camera& camera, int width_px) {
  Canvas canvas{{}, camera, static_cast<double>(width_px) / camera.width};
  const cv::Size size(width_px, std::max(1, static_cast<int>(std::lround(camera.height * canvas.scale))));
  cv::resize(image, canvas.image, size, 0, 0, canvas.scale < 1 ? cv::INTER_AREA : cv::INTER_LINEAR);
  return canvas;
}

void tint_masks(Canvas& canvas, const cv::Mat& masks) {
  cv::Mat ids;
  cv::resize(masks, ids, canvas.image.size(), 0, 0, cv::INTER_NEAREST);
  for (int y = 0; y < ids.rows; ++y)
    for (int x = 0; x < ids.cols; ++x) {
      const int id = ids.at<std::uint16_t>(y, x);
      if (id == 0) continue;
      const bool border = (x > 0 && ids.at<std::uint16_t>(y, x - 1) != id) ||
                          (y > 0 && ids.at<std::uint16_t>(y - 1, x) != id) ||
                          (x + 1 < ids.cols && ids.at<std::uint16_t>(y, x + 1) != id) ||
                          (y + 1 < ids.rows && ids.at<std::uint16_t>(y + 1, x) != id);
      const cv::Vec3b tint = kIdColors[static_cast<std::size_t>(id - 1) % std::size(kIdColors)];
      auto& pixel = canvas.image.at<cv::Vec3b>(y, x);
      const double share = border ? 2 * kTint : kTint;
      for (int c = 0; c < 3; ++c)
        pixel[c] = cv::saturate_cast<std::uint8_t>((1 - share) * pixel[c] + share * tint[c]);
    }
}

void draw_polygon(Canvas& canvas, const std::vector<Eigen::Vector2d>& corners, const cv::Scalar& color,
                  int line_px) {
  std::vector<cv::Point> points;
  const Camera& camera = canvas.camera;
  for (const Eigen::Vector2d& p : camera.has_distortion() ? cut_sides(corners) : corners) {
    const auto pixel =
        camera.has_distortion()
            ? camera.project({(p.x() - camera.cx) / camera.fx, (p.y() - camera.cy) / camera.fy, 1})
            : p;
    const auto point = pixel ? fixed_point(canvas, *pixel) : std::nullopt;
    if (!point) return;
    points.push_back(*point);
  }
  cv::polylines(canvas.image, points, true, color, line_px, cv::LINE_AA, kShift);
}

void draw_rectangle(Canvas& canvas, const Ellipse& ellipse, const cv::Scalar& color, int line_px) {
  draw_polygon(canvas, rectangle_corners(ellipse), color, line_px);
}

void draw_box(Canvas& canvas, const Pose& camera_from_object, const Eigen::Vector3d& semi_axes_m,
              const cv::Scalar& color, int line_px) {
  const auto corner = [&](int signs) {
    const Eigen::Vector3d sign(signs & 1 ? 1 : -1, signs & 2 ? 1 : -1, signs & 4 ? 1 : -1);
    return Eigen::Vector3d(camera_from_object * sign.cwiseProduct(semi_axes_m).eval());
  };
  for (int from = 0; from < 8; ++from)
    for (const int axis : {1, 2, 4})
      if ((from & axis) == 0) draw_edge(canvas, corner(from), corner(from | axis), color, line_px);
}

void draw_label(Canvas& canvas, const std::string& text, cv::Point2d at, const cv::Scalar& color) {
  constexpr double kSize = 0.45;
  const cv::Size size = cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, kSize, 1, nullptr);
  const cv::Point corner(
      std::clamp(static_cast<int>(at.x) - size.width / 2, 2, std::max(2, canvas.image.cols - size.width - 2)),
      std::clamp(static_cast<int>(at.y), size.height + 2, std::max(size.height + 2, canvas.image.rows - 4)));
  cv::putText(canvas.image, text, corner, cv::FONT_HERSHEY_SIMPLEX, kSize, kBlack, 3, cv::LINE_AA);
  cv::putText(canvas.image, text, corner, cv::FONT_HERSHEY_SIMPLEX, kSize, color, 1, cv::LINE_AA);
}

}  // namespace uniquadric
