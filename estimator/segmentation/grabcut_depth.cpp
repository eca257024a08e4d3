#include "estimator/segmentation/grabcut_depth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/images/support_planes.h"
#include "estimator/images/surface_normals.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

constexpr int kMaxPlanes = 3;              // a floor and two walls
constexpr double kNormalReach = 0.05;      // of the box's shorter side, over which a normal is measured
constexpr std::size_t kRingPoints = 2000;  // enough to find a plane of a seventh of them

// The pixels from a corner to the opposite one, of those in the image: a box may reach beyond what an int
// holds.
cv::Rect pixel_rect(double left, double top, double right, double bottom, const cv::Mat& image) {
  left = std::max(std::floor(left), 0.0);
  top = std::max(std::floor(top), 0.0);
  right = std::min(std::ceil(right), static_cast<double>(image.cols));
  bottom = std::min(std::ceil(bottom), static_cast<double>(image.rows));
  if (!(left < right && top < bottom)) return {};
  return {cv::Point(static_cast<int>(left), static_cast<int>(top)),
          cv::Point(static_cast<int>(right), static_cast<int>(bottom))};
}

// Median of the depth in the middle half of the box, where the object is most likely.
std::optional<double> median_depth(const cv::Mat& depth, const BoxPrompt& box) {
  const cv::Rect middle = pixel_rect(box.x + box.width / 4, box.y + box.height / 4, box.x + 0.75 * box.width,
                                     box.y + 0.75 * box.height, depth);
  std::vector<float> values;
  for (int v = middle.y; v < middle.br().y; ++v)
    for (int u = middle.x; u < middle.br().x; ++u)
      if (depth.at<float>(v, u) > 0) values.push_back(depth.at<float>(v, u));
  if (values.empty()) return std::nullopt;
  return upper_median(std::move(values));
}

std::vector<Plane> planes_of_ring(const cv::Mat& depth, const Camera& camera, const cv::Rect& outer,
                                  const cv::Rect& inner, const GrabcutOptions& options,
                                  RandomStream& random) {
  std::vector<Eigen::Vector3d> points;
  for (int v = outer.y; v < outer.br().y; ++v)
    for (int u = outer.x; u < outer.br().x; ++u)
      if (!inner.contains({u, v}))
        if (const auto p = depth_point(depth, camera, u, v)) points.push_back(*p);
  const std::size_t step = points.size() / kRingPoints + 1;
  std::vector<Eigen::Vector3d> some;
  for (std::size_t i = 0; i < points.size(); i += step) some.push_back(points[i]);
  return find_planes(std::move(some), options.plane_threshold_m, options.plane_share, kMaxPlanes, random);
}

// 255 where depth says that a pixel of the box cannot be the object: it is far off in depth, or on a plane
// and faces as the plane does. The foot of what stands on a plane is on it too, and faces elsewhere.
cv::Mat excluded_by_depth(const cv::Mat& depth, const Camera& camera, const cv::Rect& inner, double median_m,
                          double reach_m, const std::vector<Plane>& planes, const GrabcutOptions& options) {
  cv::Mat excluded = cv::Mat::zeros(depth.size(), CV_8UC1);
  const int reach_px = std::max(1, static_cast<int>(kNormalReach * std::min(inner.width, inner.height)));
  const cv::Mat normals = surface_normals(depth, camera, inner, reach_px);
  for (int v = inner.y; v < inner.br().y; ++v)
    for (int u = inner.x; u < inner.br().x; ++u) {
      const auto p = depth_point(depth, camera, u, v);
      if (!p) continue;
      const auto on = [&](const Plane& plane) {
        return faces_as(plane, normals.at<cv::Vec3d>(v - inner.y, u - inner.x)) &&
               lies_on(plane, *p, options.plane_threshold_m);
      };
      if (std::abs(p->z() - median_m) > reach_m || std::any_of(planes.begin(), planes.end(), on))
        excluded.at<unsigned char>(v, u) = 255;
    }
  return excluded;
}

// 255 at pixels whose right or lower neighbour is at another depth.
cv::Mat depth_jumps(const cv::Mat& depth, const cv::Rect& inner, double jump) {
  cv::Mat edges = cv::Mat::zeros(depth.size(), CV_8UC1);
  for (int v = inner.y; v + 1 < inner.br().y; ++v)
    for (int u = inner.x; u + 1 < inner.br().x; ++u) {
      const float z = depth.at<float>(v, u);
      for (const float other : {depth.at<float>(v, u + 1), depth.at<float>(v + 1, u)})
        if (z > 0 && other > 0 && std::abs(other - z) > jump * std::min(z, other))
          edges.at<unsigned char>(v, u) = 255;
    }
  return edges;
}

cv::Mat largest_component(const cv::Mat& mask) {
  cv::Mat labels, statistics, centroids;
  const int count = cv::connectedComponentsWithStats(mask, labels, statistics, centroids, 4);
  int best = 0;
  for (int i = 1; i < count; ++i)
    if (best == 0 || statistics.at<int>(i, cv::CC_STAT_AREA) > statistics.at<int>(best, cv::CC_STAT_AREA))
      best = i;
  return best == 0 ? cv::Mat(cv::Mat::zeros(mask.size(), CV_8UC1)) : cv::Mat(labels == best);
}

// 255 where depth alone tells the object: what stands clear of the planes around it, in one piece, without
// its rim, which is left to colour. Nothing where no plane was found.
cv::Mat certain_by_depth(const cv::Mat& depth, const cv::Mat& excluded, const cv::Rect& inner,
                         const std::vector<Plane>& planes, const GrabcutOptions& options) {
  cv::Mat certain = cv::Mat::zeros(depth.size(), CV_8UC1);
  if (planes.empty()) return certain;
  certain(inner).setTo(255, depth(inner) > 0);
  certain.setTo(0, excluded);
  certain.setTo(0, depth_jumps(depth, inner, options.depth_jump));
  const int radius = static_cast<int>(options.rim * std::min(inner.width, inner.height)) + 1;
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
  cv::morphologyEx(certain, certain, cv::MORPH_CLOSE, cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3}));
  cv::erode(certain, certain, disc, {-1, -1}, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  return largest_component(certain);
}

// The foreground by colour: certain background outside `inner` and where excluded, certain foreground as
// given.
cv::Mat run_grabcut(const cv::Mat& rgb, const cv::Mat& excluded, const cv::Mat& certain,
                    const cv::Rect& outer, const cv::Rect& inner, const GrabcutOptions& options,
                    RandomStream& random) {
  cv::Mat labels(rgb.size(), CV_8UC1, cv::Scalar(cv::GC_BGD));
  labels(inner).setTo(cv::GC_PR_FGD);
  labels.setTo(cv::GC_BGD, excluded);
  labels.setTo(cv::GC_FGD, certain);
  cv::Mat image, small;
  const double scale = 1.0 / options.downscale;
  cv::resize(rgb(outer), image, {}, scale, scale, cv::INTER_AREA);
  cv::resize(labels(outer), small, image.size(), 0, 0, cv::INTER_NEAREST);
  const auto is_foreground = [](const cv::Mat& l) {
    return cv::Mat((l & 1) != 0);
  };  // GC_FGD = 1, GC_PR_FGD = 3
  if (cv::countNonZero(is_foreground(small)) == 0 || cv::countNonZero(small == cv::GC_BGD) == 0)
    return is_foreground(labels);  // nothing to tell apart by colour
  cv::theRNG().state =
      (std::uint64_t{random.bits()} << 32) | random.bits();  // k-means draws from the thread's own
  cv::Mat background_model, foreground_model, enlarged;
  cv::grabCut(image, small, {}, background_model, foreground_model, options.iterations,
              cv::GC_INIT_WITH_MASK);
  cv::resize(is_foreground(small), enlarged, outer.size(), 0, 0, cv::INTER_NEAREST);
  cv::Mat foreground = cv::Mat::zeros(rgb.size(), CV_8UC1);
  enlarged.copyTo(foreground(outer));
  foreground.setTo(0, excluded);
  return foreground;
}

cv::Mat without_holes(const cv::Mat& mask) {
  std::vector<std::vector<cv::Point>> outlines;
  cv::findContours(mask, outlines, cv::RETR_EXTERNAL, cv::CHAIN_APPROX_NONE);
  cv::Mat filled = cv::Mat::zeros(mask.size(), CV_8UC1);
  cv::drawContours(filled, outlines, -1, cv::Scalar(255), cv::FILLED);
  return filled;
}

}  // namespace

cv::Mat grabcut_depth(const cv::Mat& rgb, const cv::Mat& depth, const Camera& camera, const BoxPrompt& box,
                      const GrabcutOptions& options, RandomStream& random) {
  const auto median_m = median_depth(depth, box);
  if (!median_m) return cv::Mat::zeros(rgb.size(), CV_8UC1);
  const cv::Rect inner = pixel_rect(box.x, box.y, box.x + box.width, box.y + box.height, rgb);
  const double dx = options.context * box.width, dy = options.context * box.height;
  const cv::Rect outer =
      pixel_rect(box.x - dx, box.y - dy, box.x + box.width + dx, box.y + box.height + dy, rgb);
  const double size_m = *median_m * std::max(box.width / camera.fx, box.height / camera.fy);
  const auto planes = planes_of_ring(depth, camera, outer, inner, options, random);
  const cv::Mat excluded =
      excluded_by_depth(depth, camera, inner, *median_m, options.depth_reach * size_m, planes, options);
  const cv::Mat certain = certain_by_depth(depth, excluded, inner, planes, options);
  cv::Mat mask = run_grabcut(rgb, excluded, certain, outer, inner, options, random);
  mask.setTo(0, depth_jumps(depth, inner, options.depth_jump));
  const cv::Mat disc = cv::getStructuringElement(cv::MORPH_ELLIPSE, {3, 3});
  cv::morphologyEx(mask, mask, cv::MORPH_OPEN, disc);
  return without_holes(largest_component(mask));
}

}  // namespace uniquadric
