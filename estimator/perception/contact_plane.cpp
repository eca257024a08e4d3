#include "estimator/perception/contact_plane.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <vector>

#include "core/base/quantile.h"
#include "estimator/images/support_planes.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr int kMostPoints = 400;  // of the ring, and of the body
constexpr int kClearPx = 3;       // between mask and ring, and that the mask is eroded by: its border errs
constexpr int kMinPoints = 30;
constexpr int kMostPlanes = 2;             // a table and the floor behind it
constexpr double kReachPx = 3 * kClearPx;  // of what is left, above the plane: a corner is narrow

cv::Mat grown(const cv::Mat& mask, int by_px) {
  cv::Mat result;
  cv::dilate(mask, result, cv::getStructuringElement(cv::MORPH_RECT, {2 * by_px + 1, 2 * by_px + 1}));
  return result;
}

std::vector<Eigen::Vector3d> points_of(const cv::Mat& depth, const cv::Mat& mask, const cv::Point& corner,
                                       const Camera& camera) {
  std::vector<cv::Point> pixels;
  for (int v = 0; v < mask.rows; ++v)
    for (int u = 0; u < mask.cols; ++u)
      if (mask.at<unsigned char>(v, u) && depth.at<float>(v, u) > 0) pixels.emplace_back(u, v);
  std::vector<Eigen::Vector3d> points;
  for (const auto k : even_choice(std::ssize(pixels), kMostPoints)) {
    const cv::Point& p = pixels[k];
    if (const auto ray = camera.unproject({p.x + corner.x, p.y + corner.y}))
      points.push_back(depth.at<float>(p) * *ray);
  }
  return points;
}

// The plane, if the body, at this depth, stands on it.
std::optional<ContactPlane> touched(Plane plane, const std::vector<Eigen::Vector3d>& body, double depth_m,
                                    const Camera& camera, const ContactOptions& options) {
  if (plane.offset_m < 0) plane = {-plane.normal, -plane.offset_m, plane.spread};  // towards the camera
  std::vector<double> heights;
  for (const Eigen::Vector3d& p : body) heights.push_back(plane.normal.dot(p) + plane.offset_m);
  const double noise_m = plane.spread * depth_m;
  const auto at_share = [&](double share) {
    const auto at =
        heights.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(heights.size()));
    std::nth_element(heights.begin(), at, heights.end());
    return *at;
  };
  if (at_share(options.max_below) < -4 * noise_m) return std::nullopt;
  if (at_share(options.lowest_share) > 4 * noise_m + kReachPx * depth_m / camera.fx) return std::nullopt;
  return ContactPlane{plane.normal, plane.offset_m, noise_m};
}

}  // namespace

std::optional<ContactPlane> contact_plane(const cv::Mat& depth, const cv::Mat& masks, int id,
                                          const Camera& camera, const ContactOptions& options,
                                          RandomStream& random) {
  if (!options.enabled) return std::nullopt;
  const cv::Mat whole = masks == id;
  const int area = cv::countNonZero(whole);
  if (area < kMinPoints) return std::nullopt;
  const int width_px = kClearPx + static_cast<int>(std::lround(options.ring * std::sqrt(area)));
  const cv::Rect box =
      cv::boundingRect(whole) + cv::Size(2 * width_px, 2 * width_px) - cv::Point(width_px, width_px);
  const cv::Rect part = box & cv::Rect({0, 0}, masks.size());
  const cv::Mat mask = whole(part), depth_here = depth(part);
  cv::Mat inner;
  cv::erode(mask, inner, cv::getStructuringElement(cv::MORPH_RECT, {2 * kClearPx + 1, 2 * kClearPx + 1}));
  const cv::Mat ring = grown(mask, width_px) & ~grown(mask, kClearPx) & (masks(part) == 0);
  const auto about = points_of(depth_here, ring, part.tl(), camera),
             body = points_of(depth_here, inner, part.tl(), camera);
  if (std::ssize(about) < kMinPoints || std::ssize(body) < kMinPoints) return std::nullopt;
  std::vector<double> depths;
  for (const auto& p : body) depths.push_back(p.z());
  const double depth_m = upper_median(std::move(depths));
  for (const Plane& plane :
       find_planes(about, options.threshold * depth_m, options.min_share, kMostPlanes, random))
    if (const auto contact = touched(plane, body, depth_m, camera, options)) return contact;
  return std::nullopt;
}

}  // namespace uniquadric
