#include "benchmarks/undistortion_svg.h"

#include <fmt/format.h>

#include <opencv2/imgproc.hpp>

namespace uniquadric {
namespace {

constexpr double kWidth = 300, kGap = 14, kTop = 52, kBottom = 30;  // of a panel [px]

constexpr const char* kStyle =
    "<style>\ntext{font:12px system-ui,\"Segoe UI\",\"DejaVu Sans\",sans-serif;fill:#1d2126}\n"
    ".title{font-weight:600}.small{font-size:11px;fill:#5c6670}\n"
    ".back{fill:#ffffff}.frame{fill:none;stroke:#e2dfd9}.body{fill:#0072b2;fill-opacity:.10;stroke:#0072b2}\n"
    ".point{stroke:#d55e00}.scale{stroke:#5c6670;stroke-width:2}\n"
    "@media (prefers-color-scheme:dark){text{fill:#e8e6e3}.small{fill:#9aa3ac}.back{fill:#1c2024}"
    ".frame{stroke:#2f353b}.body{fill:#4aa8e8;stroke:#4aa8e8}.point{stroke:#ff8f3f}.scale{stroke:#9aa3ac}}\n"
    "</style>\n";

// From above, in metres, to a panel's pixels.
struct View {
  Eigen::Vector2d least, most;
  double px_per_m = 1;
  Eigen::Vector2d at(const Eigen::Vector3d& p) const {
    return {(p.x() - least.x()) * px_per_m, kTop + (most.y() - p.y()) * px_per_m};
  }
  bool shows(const Eigen::Vector3d& p) const {
    return (p.head<2>().array() > least.array()).all() && (p.head<2>().array() < most.array()).all();
  }
  double height() const { return (most.y() - least.y()) * px_per_m; }
};

std::string outline_of(const std::vector<Eigen::Vector3d>& vertices, const View& view) {
  std::vector<cv::Point2f> flat, hull;
  for (const Eigen::Vector3d& v : vertices) flat.emplace_back(float(view.at(v).x()), float(view.at(v).y()));
  cv::convexHull(flat, hull);
  std::string path;
  for (const cv::Point2f& p : hull)
    path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", p.x, p.y);
  return fmt::format("<path class=\"body\" d=\"{}Z\"/>\n", path);
}

std::string panel_text(const UndistortionPanel& panel, const std::vector<Eigen::Vector3d>& vertices,
                       const View& view) {
  std::string text = fmt::format("<text class=\"title\" x=\"0\" y=\"18\">{}</text>\n", panel.title);
  text += fmt::format("<text class=\"small\" x=\"0\" y=\"36\">{}</text>\n", panel.subtitle);
  text += fmt::format("<rect class=\"frame\" y=\"{}\" width=\"{}\" height=\"{:.1f}\"/>\n", kTop, kWidth,
                      view.height());
  text += outline_of(vertices, view);
  std::string dots;
  for (const Eigen::Vector3d& point : panel.points)
    if (view.shows(point)) dots += fmt::format("M{:.1f} {:.1f}h.01", view.at(point).x(), view.at(point).y());
  text +=
      fmt::format("<path class=\"point\" d=\"{}\" style=\"stroke-width:2.2;stroke-linecap:round\"/>\n", dots);
  const double y = kTop + view.height() + 16;
  return text + fmt::format(
                    "<path class=\"scale\" d=\"M0 {0:.1f}h{1:.1f}\"/><text class=\"small\" x=\"{2:.1f}\" "
                    "y=\"{3:.1f}\">1 m</text>\n",
                    y, view.px_per_m, view.px_per_m + 6, y + 4);
}

}  // namespace

std::string undistortion_svg(const std::vector<UndistortionPanel>& panels,
                             const std::vector<Eigen::Vector3d>& vertices, double margin_m) {
  View view{vertices.front().head<2>(), vertices.front().head<2>()};
  for (const Eigen::Vector3d& v : vertices) {
    view.least = view.least.cwiseMin(v.head<2>());
    view.most = view.most.cwiseMax(v.head<2>());
  }
  view.least.array() -= margin_m, view.most.array() += margin_m;
  view.px_per_m = kWidth / (view.most - view.least).x();
  const double width = kGap + double(panels.size()) * (kWidth + kGap);
  const double height = kTop + view.height() + kBottom;
  std::string text = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\" aria-label=\"points of a moving body from above, by what is undone of "
      "the motion\">\n{2}<rect class=\"back\" width=\"100%\" height=\"100%\"/>\n",
      width, height, kStyle);
  for (std::size_t i = 0; i < panels.size(); ++i)
    text += fmt::format("<g transform=\"translate({:.0f} 0)\">\n{}</g>\n", kGap + double(i) * (kWidth + kGap),
                        panel_text(panels[i], vertices, view));
  return text + "</svg>\n";
}

}  // namespace uniquadric
