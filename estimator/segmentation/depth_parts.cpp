#include "estimator/segmentation/depth_parts.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "estimator/images/surface_normals.h"
#include "estimator/shape/depth_point.h"

namespace uniquadric {
namespace {

constexpr std::size_t kPlanePoints = 3000;  // enough to find a plane of a twentieth of them
constexpr int kNormalReach_px = 7;          // of the noise of correlated depth enough is averaged
constexpr int kPointReach_px = 6;           // a point prompt beside a part, on a pixel without depth say

// Points of a coarse grid over the image.
std::vector<Eigen::Vector3d> some_points(const cv::Mat& depth, const Camera& camera) {
  const int step =
      std::max(1, static_cast<int>(std::sqrt(static_cast<double>(depth.total()) / kPlanePoints)));
  std::vector<Eigen::Vector3d> points;
  for (int v = step / 2; v < depth.rows; v += step)
    for (int u = step / 2; u < depth.cols; u += step)
      if (const auto point = depth_point(depth, camera, u, v)) points.push_back(*point);
  return points;
}

// Of a depth image: where what is seen stands clear of all planes, and where it is near one and faces
// elsewhere, as the foot of what stands on it.
constexpr unsigned char kClear = 255, kFoot = 128;

unsigned char standing(const Eigen::Vector3d& point, const cv::Vec3d& normal,
                       const std::vector<Plane>& planes, double threshold_m) {
  const double threshold = threshold_m * std::max(point.z(), 1.0);
  unsigned char result = kClear;
  for (const Plane& plane : planes)
    if (lies_on(plane, point, threshold)) {
      if (faces_as(plane, normal)) return 0;
      result = kFoot;
    }
  return result;
}

cv::Mat clear_of_planes(const cv::Mat& depth, const Camera& camera, const std::vector<Plane>& planes,
                        const DepthPartsOptions& options) {
  cv::Mat clear = cv::Mat::zeros(depth.size(), CV_8UC1);
  const cv::Mat normals = surface_normals(depth, camera, {{0, 0}, depth.size()}, kNormalReach_px);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u)
      if (const auto point = depth_point(depth, camera, u, v))
        clear.at<unsigned char>(v, u) =
            standing(*point, normals.at<cv::Vec3d>(v, u), planes, options.plane_threshold_m);
  return clear;
}

// Labels joined by a rule over neighbours (union-find).
class Joining {
 public:
  explicit Joining(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }
  int root(int i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  void join(int a, int b) {
    a = root(a), b = root(b);
    parent_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<int> parent_;
};

// Joins neighbours without a jump in depth; pixels whose depth is missing are bridged over two pixels.
Joining join_neighbours(const cv::Mat& depth, const cv::Mat& clear, double jump) {
  Joining joining(depth.total());
  const auto index = [&](int v, int u) { return v * depth.cols + u; };
  const auto join = [&](int v, int u, int y, int x) {
    if (y >= depth.rows || x >= depth.cols || !clear.at<unsigned char>(y, x)) return;
    const float a = depth.at<float>(v, u), b = depth.at<float>(y, x);
    if (std::abs(a - b) < jump * std::min(a, b)) joining.join(index(v, u), index(y, x));
  };
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      if (!clear.at<unsigned char>(v, u)) continue;
      for (const int step : {1, 2}) {
        join(v, u, v, u + step);
        join(v, u, v + step, u);
      }
    }
  return joining;
}

struct Part {
  int pixels = 0, clear_pixels = 0, left = 0, right = 0, top = 0, bottom = 0;
  double depth_sum_m = 0;
};

bool is_body(const Part& part, const Camera& camera, const DepthPartsOptions& options) {
  const double z = part.depth_sum_m / part.pixels;
  const double extent_m =
      z * std::max((part.right - part.left) / camera.fx, (part.bottom - part.top) / camera.fy);
  return part.clear_pixels >= options.min_pixels && extent_m <= options.max_extent_m;
}

}  // namespace

cv::Mat depth_parts(const cv::Mat& depth, const Camera& camera, const DepthPartsOptions& options,
                    RandomStream& random) {
  const double middle_m = std::max(1.0, cv::mean(depth, depth > 0)[0]);
  const auto planes = find_planes(some_points(depth, camera), options.plane_threshold_m * middle_m,
                                  options.plane_share, options.max_planes, random);
  const cv::Mat clear = clear_of_planes(depth, camera, planes, options);
  Joining joining = join_neighbours(depth, clear, options.jump);
  std::map<int, Part> parts;
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      if (!clear.at<unsigned char>(v, u)) continue;
      const auto [entry, is_new] = parts.try_emplace(joining.root(v * depth.cols + u),
                                                     Part{.left = u, .right = u, .top = v, .bottom = v});
      Part& part = entry->second;
      ++part.pixels;
      part.clear_pixels += clear.at<unsigned char>(v, u) == kClear ? 1 : 0;
      part.left = std::min(part.left, u), part.right = std::max(part.right, u), part.bottom = v;
      part.depth_sum_m += depth.at<float>(v, u);
    }
  std::erase_if(parts, [&](const auto& entry) { return !is_body(entry.second, camera, options); });
  std::vector<std::pair<int, int>> order;  // -pixels, root
  for (const auto& [root, part] : parts) order.emplace_back(-part.pixels, root);
  std::sort(order.begin(), order.end());
  std::map<int, std::uint16_t> label_of;
  for (const auto& [pixels, root] : order)
    label_of.emplace(root, static_cast<std::uint16_t>(label_of.size() + 1));
  cv::Mat labels = cv::Mat::zeros(depth.size(), CV_16UC1);
  for (int v = 0; v < depth.rows; ++v)
    for (int u = 0; u < depth.cols; ++u) {
      if (!clear.at<unsigned char>(v, u)) continue;
      const auto label = label_of.find(joining.root(v * depth.cols + u));
      if (label != label_of.end()) labels.at<std::uint16_t>(v, u) = label->second;
    }
  return labels;
}

int label_near(const cv::Mat& labels, const PointPrompt& point) {
  const cv::Rect image({0, 0}, labels.size());
  const cv::Rect around(static_cast<int>(point.u) - kPointReach_px,
                        static_cast<int>(point.v) - kPointReach_px, 2 * kPointReach_px + 1,
                        2 * kPointReach_px + 1);
  const cv::Rect window = around & image;
  int nearest = 0;
  double least = kPointReach_px + 0.5;
  for (int v = window.y; v < window.br().y; ++v)
    for (int u = window.x; u < window.br().x; ++u) {
      const double distance = std::hypot(u - point.u, v - point.v);
      if (labels.at<std::uint16_t>(v, u) == 0 || distance >= least) continue;
      least = distance;
      nearest = labels.at<std::uint16_t>(v, u);
    }
  return nearest;
}

cv::Mat parts_at_points(const cv::Mat& parts, const std::vector<PointPrompt>& points) {
  cv::Mat masks = cv::Mat::zeros(parts.size(), CV_16UC1);
  for (const PointPrompt& point : points)
    if (const int part = label_near(parts, point); part != 0) masks.setTo(point.id, parts == part);
  return masks;
}

}  // namespace uniquadric
