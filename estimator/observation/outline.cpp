#include "estimator/observation/outline.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

double cross(const Eigen::Vector2d& o, const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return (a.x() - o.x()) * (b.y() - o.y()) - (a.y() - o.y()) * (b.x() - o.x());
}

constexpr int kSpeckPixels = 8;      // a part smaller than this is a speck wherever it lies
constexpr double kNearShare = 0.35;  // of the largest part's side: nearer parts are the body's, as wheels are

// Erases the parts of a mask that are small beside its largest and lie away from it; returns the pixels left.
int erase_specks(cv::Mat& mask, double min_share) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, statistics, centroids, 8);
  if (count <= 2) return count < 2 ? 0 : statistics.at<int>(1, cv::CC_STAT_AREA);
  const auto area = [&](int label) { return statistics.at<int>(label, cv::CC_STAT_AREA); };
  int largest = 1, kept = 0;
  for (int label = 2; label < count; ++label)
    if (area(label) > area(largest)) largest = label;
  cv::Mat distance;
  cv::distanceTransform(labels != largest, distance, cv::DIST_L2, 3);
  for (int label = 1; label < count; ++label) {
    double gap = 0;
    cv::minMaxLoc(distance, &gap, nullptr, nullptr, nullptr, labels == label);
    const bool is_near = area(label) >= kSpeckPixels && gap < kNearShare * std::sqrt(area(largest));
    if (is_near || area(label) >= min_share * area(largest))
      kept += area(label);
    else
      mask.setTo(0, labels == label);
  }
  return kept;
}

}  // namespace

std::map<int, cv::Rect> id_boxes(const cv::Mat& masks) {
  std::map<int, cv::Rect> boxes;
  for (int v = 0; v < masks.rows; ++v) {
    const auto* row = masks.ptr<std::uint16_t>(v);
    for (int u = 0; u < masks.cols;) {
      const int id = row[u], begin = u;
      while (u < masks.cols && row[u] == id) ++u;
      if (id == 0) continue;
      const cv::Rect run(begin, v, u - begin, 1);
      const auto [entry, is_new] = boxes.try_emplace(id, run);
      if (!is_new) entry->second |= run;
    }
  }
  return boxes;
}

std::map<int, MaskRegion> mask_regions(const cv::Mat& masks, int min_pixels, double min_share) {
  std::map<int, MaskRegion> regions;
  for (const auto& [id, box] : id_boxes(masks)) {
    MaskRegion region{box, masks(box) == id, 0};
    region.area_px = erase_specks(region.mask, min_share);
    if (region.area_px >= min_pixels) regions.emplace(id, std::move(region));
  }
  return regions;
}

std::vector<OutlinePoint> outline_points(const MaskRegion& region, const Camera& camera) {
  std::vector<OutlinePoint> points;
  const cv::Mat_<unsigned char> mask(region.mask);
  const auto is_in = [&](int u, int v) {
    return u >= 0 && v >= 0 && u < mask.cols && v < mask.rows && mask(v, u) != 0;
  };
  const auto add = [&](double u, double v) {
    const Eigen::Vector2d image(u + region.box.x, v + region.box.y);
    if (!camera.has_distortion()) return points.push_back({image, image});
    if (const auto ray = camera.unproject(image)) points.push_back({image, ideal_pixel(camera, *ray)});
  };
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u) {
      if (mask(v, u) == 0) continue;
      if (!is_in(u - 1, v)) add(u - 0.5, v);
      if (!is_in(u + 1, v)) add(u + 0.5, v);
      if (!is_in(u, v - 1)) add(u, v - 0.5);
      if (!is_in(u, v + 1)) add(u, v + 0.5);
    }
  return points;
}

// Andrew's monotone chains.
std::vector<Eigen::Vector2d> convex_hull(std::vector<Eigen::Vector2d> points) {
  std::sort(points.begin(), points.end(),
            [](const auto& a, const auto& b) { return std::pair(a.x(), a.y()) < std::pair(b.x(), b.y()); });
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() < 3) return points;
  std::vector<Eigen::Vector2d> hull;
  const auto extend = [&](const Eigen::Vector2d& p, std::size_t first) {
    while (hull.size() >= first + 2 && cross(hull[hull.size() - 2], hull.back(), p) <= 0) hull.pop_back();
    hull.push_back(p);
  };
  for (const auto& p : points) extend(p, 0);
  const std::size_t first = hull.size() - 1;
  for (auto p = points.rbegin() + 1; p != points.rend(); ++p) extend(*p, first);
  hull.pop_back();
  return hull;
}

double least_rectangle_angle(const std::vector<Eigen::Vector2d>& hull) {
  constexpr double kTie = 1 - 1e-9;  // of equal rectangles the first edge's
  if (hull.size() < 3) return 0;
  double least = 0, angle = 0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Eigen::Vector2d along = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    const Eigen::Vector2d across(-along.y(), along.x());
    const double area = (support_offset(hull, along) + support_offset(hull, -along)) *
                        (support_offset(hull, across) + support_offset(hull, -across));
    if (i > 0 && area >= kTie * least) continue;
    least = area;
    angle = std::atan2(along.y(), along.x());
  }
  const double quarter = std::numbers::pi / 2;
  angle = std::fmod(angle, quarter);
  if (angle < 0) angle += quarter;
  return angle < quarter ? angle : 0;
}

double support_offset(const std::vector<Eigen::Vector2d>& points, const Eigen::Vector2d& normal) {
  double offset = normal.dot(points.front());
  for (const auto& p : points) offset = std::max(offset, normal.dot(p));
  return offset;
}

}  // namespace uniquadric
