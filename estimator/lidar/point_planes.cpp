#include "estimator/lidar/point_planes.h"

#include <tbb/parallel_for.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/quantile.h"
#include "estimator/features/surface_descriptor.h"
#include "estimator/lidar/pixel_grid.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr int kRounds = 2;
constexpr double kSliverShare = 0.2;  // of the largest surface's points; larger ones are the body's too
constexpr double kOutlierSigmas = 2.5, kLeastScatter = 2e-4;  // of inverse depth, relative

int root(std::vector<int>& parent, int i) {
  while (parent[i] != i) i = parent[i] = parent[parent[i]];
  return i;
}

// Which points hang together without a jump in depth: the number of each one's surface.
std::vector<int> surfaces(const std::vector<ImagePoint>& points,
                          const std::vector<std::vector<std::size_t>>& near, double max_jump) {
  std::vector<int> parent(points.size());
  std::iota(parent.begin(), parent.end(), 0);
  for (std::size_t i = 0; i < points.size(); ++i)
    for (const std::size_t j : near[i])
      if (std::abs(points[i].inverse_depth - points[j].inverse_depth) < max_jump * points[i].inverse_depth)
        parent[root(parent, static_cast<int>(i))] = root(parent, static_cast<int>(j));
  for (std::size_t i = 0; i < points.size(); ++i) parent[i] = root(parent, static_cast<int>(i));
  return parent;
}

// What a mask takes in beside its body or a window lets through: small surfaces off the depths of the
// largest.
std::vector<bool> on_body(const std::vector<ImagePoint>& points, const std::vector<int>& surface) {
  struct Part {
    std::size_t count = 0;
    double sum = 0, least = std::numeric_limits<double>::infinity(), most = 0;
  };
  std::map<int, Part> parts;
  for (std::size_t i = 0; i < points.size(); ++i) {
    Part& part = parts[surface[i]];
    const double w = points[i].inverse_depth;
    ++part.count, part.sum += w;
    part.least = std::min(part.least, w), part.most = std::max(part.most, w);
  }
  const Part& main = std::max_element(parts.begin(), parts.end(), [](const auto& a, const auto& b) {
                       return a.second.count < b.second.count;
                     })->second;
  std::vector<bool> on(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Part& part = parts[surface[i]];
    const double mean = part.sum / static_cast<double>(part.count);
    on[i] = static_cast<double>(part.count) > kSliverShare * static_cast<double>(main.count) ||
            (mean >= main.least && mean <= main.most);
  }
  return on;
}

struct Fit {
  Eigen::Vector3d plane;  // w0, slope
  double scatter = 0;
  int count = 0;
};

// A neighbour, as the point in the middle sees it.
struct Neighbour {
  double x, y, inverse_depth;
};

std::optional<Fit> fit(const std::vector<Neighbour>& near, const Eigen::Vector3d& about, double gate) {
  double n = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0, squares = 0;
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Neighbour& p : near) {
    const double off = p.inverse_depth - (about[0] + p.x * about[1] + p.y * about[2]);
    if (std::abs(off) > gate) continue;
    n += 1, x += p.x, y += p.y;
    xx += p.x * p.x, xy += p.x * p.y, yy += p.y * p.y;
    right += off * Eigen::Vector3d(1, p.x, p.y);
    squares += off * off;
  }
  if (n < 4) return std::nullopt;
  Eigen::Matrix3d normal, inverse;
  normal << n, x, y, x, xx, xy, y, xy, yy;
  bool invertible = false;
  normal.computeInverseWithCheck(inverse, invertible, 1e-9);
  if (!invertible) return std::nullopt;  // all in one line
  const Eigen::Vector3d change = inverse * right;
  return Fit{about + change, std::sqrt(std::max(0.0, squares - change.dot(right)) / (n - 3)),
             static_cast<int>(n)};
}

std::optional<PointPlane> plane_at(const ImagePoint& here, const std::vector<Neighbour>& near,
                                   const PointPlaneOptions& options) {
  Eigen::Vector3d about(here.inverse_depth, 0, 0);
  double gate = options.max_jump * here.inverse_depth;
  for (int round = 0; round < kRounds; ++round) {
    const auto found = fit(near, about, gate);
    if (!found || found->count < options.min_neighbours) return std::nullopt;
    about = found->plane;
    gate = kOutlierSigmas * std::max(found->scatter, kLeastScatter * here.inverse_depth);
  }
  if (std::abs(about[0] - here.inverse_depth) > options.max_jump * here.inverse_depth) return std::nullopt;
  return PointPlane{here.pixel, about[0], about.tail<2>()};
}

std::vector<Neighbour> neighbours_of(const ImagePoint& here, const std::vector<ImagePoint>& points,
                                     const std::vector<std::size_t>& near) {
  std::vector<Neighbour> result;
  result.reserve(near.size());
  for (const std::size_t i : near)
    result.push_back({points[i].pixel.x() - here.pixel.x(), points[i].pixel.y() - here.pixel.y(),
                      points[i].inverse_depth});
  return result;
}

// The points nearest to each one, itself among them.
std::vector<std::vector<std::size_t>> nearest_points(const std::vector<ImagePoint>& points, double reach_px,
                                                     std::size_t count) {
  const PixelGrid grid(points, reach_px, count);
  std::vector<std::vector<std::size_t>> near(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(),
                    [&](std::size_t i) { near[i] = grid.nearest(points[i].pixel, count); });
  return near;
}

// What v is multiplied by for rows to be as near as the points in them.
double rows_together(const std::vector<ImagePoint>& points, const PointPlaneOptions& options) {
  std::vector<double> steps_px;
  const auto near = nearest_points(points, options.reach_px, 2);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (near[i].size() == 2) steps_px.push_back((points[near[i][1]].pixel - points[i].pixel).norm());
  return steps_px.empty() ? 1 : std::min(1.0, quantile(std::move(steps_px), 0.5) / options.row_gap_px);
}

}  // namespace

std::vector<PointPlane> point_planes(const std::vector<ImagePoint>& points,
                                     const PointPlaneOptions& options) {
  if (points.empty()) return {};
  std::vector<ImagePoint> drawn = points;
  if (options.row_gap_px > 0)
    for (const double scale = rows_together(points, options); ImagePoint & p : drawn) p.pixel.y() *= scale;
  const auto near = nearest_points(drawn, options.reach_px, static_cast<std::size_t>(options.neighbours));
  std::vector<bool> keep(points.size(), true);
  if (options.one_body) keep = on_body(points, surfaces(points, near, options.max_jump));
  std::vector<std::optional<PointPlane>> found(points.size());
  tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
    if (keep[i]) found[i] = plane_at(points[i], neighbours_of(points[i], points, near[i]), options);
  });
  std::vector<PointPlane> planes;
  for (const auto& plane : found)
    if (plane) planes.push_back(*plane);
  return planes;
}

void fill_depth(const std::vector<PointPlane>& planes, int label, const cv::Mat& masks, double reach_px,
                cv::Mat& depth) {
  const cv::Rect image({}, depth.size());
  std::vector<cv::Point> pixels;
  for (const PointPlane& plane : planes)
    pixels.emplace_back(static_cast<int>(std::lround(plane.pixel.x())),
                        static_cast<int>(std::lround(plane.pixel.y())));
  if (pixels.empty()) return;
  const int margin = static_cast<int>(reach_px) + 1;
  const cv::Rect around = cv::boundingRect(pixels);
  const cv::Rect rect =
      cv::Rect(around.tl() - cv::Point(margin, margin), around.br() + cv::Point(margin, margin)) & image;
  if (rect.empty()) return;
  cv::Mat far(rect.size(), CV_8UC1, cv::Scalar(1)), nearest, distance;
  cv::Mat at(rect.size(), CV_32SC1, cv::Scalar(-1));
  for (std::size_t i = 0; i < planes.size(); ++i) {
    if (!rect.contains(pixels[i])) continue;
    far.at<unsigned char>(pixels[i] - rect.tl()) = 0;
    at.at<int>(pixels[i] - rect.tl()) = static_cast<int>(i);
  }
  cv::distanceTransform(far, distance, nearest, cv::DIST_L2, cv::DIST_MASK_5, cv::DIST_LABEL_PIXEL);
  std::vector<int> plane_of(planes.size() + 2, -1);
  for (int v = 0; v < rect.height; ++v)
    for (int u = 0; u < rect.width; ++u)
      if (const int i = at.at<int>(v, u); i >= 0)
        plane_of[static_cast<std::size_t>(nearest.at<int>(v, u))] = i;
  for (int v = rect.y; v < rect.br().y; ++v)
    for (int u = rect.x; u < rect.br().x; ++u) {
      if ((masks.empty() ? 0 : masks.at<std::uint16_t>(v, u)) != label) continue;
      const cv::Point here(u - rect.x, v - rect.y);
      if (distance.at<float>(here) > reach_px) continue;
      const PointPlane& plane =
          planes[static_cast<std::size_t>(plane_of[static_cast<std::size_t>(nearest.at<int>(here))])];
      const double w = plane.inverse_depth + plane.slope_per_px.dot(Eigen::Vector2d(u, v) - plane.pixel);
      if (w > 0.5 * plane.inverse_depth) depth.at<float>(v, u) = static_cast<float>(1 / w);
    }
}

SurfacePoints surface_points(const std::vector<PointPlane>& planes, const Camera& camera, int most) {
  const auto chosen = even_choice(std::ssize(planes), most);
  SurfacePoints result{Eigen::Matrix3Xd(3, std::ssize(chosen)), Eigen::Matrix3Xd(3, std::ssize(chosen))};
  std::ptrdiff_t count = 0;
  for (const auto i : chosen) {
    const PointPlane& plane = planes[static_cast<std::size_t>(i)];
    const auto ray = camera.unproject(plane.pixel);
    if (!ray) continue;
    const Eigen::Vector2d undistorted = (camera.matrix() * *ray).head<2>();
    const PlaneDepth surface{1 / plane.inverse_depth, 0, plane.slope_per_px, 0};
    result.points.col(count) = *ray / plane.inverse_depth;
    result.normals.col(count++) = surface_normal(camera, undistorted, surface);
  }
  return {result.points.leftCols(count), result.normals.leftCols(count)};
}

}  // namespace uniquadric
