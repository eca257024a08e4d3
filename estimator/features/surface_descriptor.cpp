#include "estimator/features/surface_descriptor.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <opencv2/features2d.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>

#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr int kTile = 64;            // side of a view: ORB wants 31 px on each side of a point
constexpr int kColumns = 16;         // of views in a sheet
constexpr int kMomentRadius = 15;    // of the patch whose centroid gives the orientation, as in ORB
constexpr double kFineness = 0.8;    // pixels of the image in one of the view: bodies are small
constexpr double kMinCosine = 0.34;  // of the angle between ray and normal: 70 degrees
constexpr int kNoDistance = 257;

// From a pixel of the view, counted from its middle, to a pixel of the image, counted from the point.
Eigen::Matrix2d image_from_view(const Camera& camera, const Eigen::Vector3d& p, const Eigen::Vector3d& normal,
                                double metres) {
  const Eigen::Vector3d right = (Eigen::Vector3d::UnitX() - normal * normal.x()).normalized();
  const Eigen::Vector3d down = right.cross(normal);
  Eigen::Matrix<double, 2, 3> J;
  J << camera.fx / p.z(), 0, -camera.fx * p.x() / (p.z() * p.z()), 0, camera.fy / p.z(),
      -camera.fy * p.y() / (p.z() * p.z());
  Eigen::Matrix<double, 3, 2> axes;
  axes << right, down;
  return metres * J * axes;
}

float orientation_deg(const cv::Mat& view) {
  double mx = 0, my = 0;
  for (int y = -kMomentRadius; y <= kMomentRadius; ++y)
    for (int x = -kMomentRadius; x <= kMomentRadius; ++x) {
      if (x * x + y * y > kMomentRadius * kMomentRadius) continue;
      const int value = view.at<std::uint8_t>(kTile / 2 + y, kTile / 2 + x);
      mx += x * value;
      my += y * value;
    }
  return cv::fastAtan2(static_cast<float>(my), static_cast<float>(mx));
}

// A sheet of views, each drawn into a tile of it.
struct Sheet {
  cv::Mat image;
  std::vector<cv::KeyPoint> points;
  std::vector<std::size_t> owners;
  std::vector<int> scales;
};

struct View {
  std::size_t owner;
  int scale;
  Eigen::Vector2d pixel;
  Eigen::Matrix2d image_from_view;
};

Sheet draw_sheet(const cv::Mat& gray, const std::vector<View>& views) {
  Sheet sheet;
  const int rows = (static_cast<int>(views.size()) + kColumns - 1) / kColumns;
  sheet.image = cv::Mat(rows * kTile, kColumns * kTile, CV_8UC1, cv::Scalar(0));
  for (std::size_t i = 0; i < views.size(); ++i) {
    const View& view = views[i];
    const int left = static_cast<int>(i % kColumns) * kTile, top = static_cast<int>(i / kColumns) * kTile;
    const Eigen::Matrix2d& A = view.image_from_view;
    const Eigen::Vector2d origin = view.pixel - A * Eigen::Vector2d(kTile / 2, kTile / 2);
    const cv::Matx23d warp(A(0, 0), A(0, 1), origin.x(), A(1, 0), A(1, 1), origin.y());
    cv::Mat tile = sheet.image(cv::Rect(left, top, kTile, kTile));
    cv::warpAffine(gray, tile, warp, tile.size(), cv::INTER_LINEAR | cv::WARP_INVERSE_MAP,
                   cv::BORDER_REPLICATE);
    sheet.points.emplace_back(static_cast<float>(left + kTile / 2), static_cast<float>(top + kTile / 2), 31.F,
                              orientation_deg(tile), 1.F, 0);
    sheet.owners.push_back(view.owner);
    sheet.scales.push_back(view.scale);
  }
  return sheet;
}

void add_views(const Camera& lens, const SurfacePoint& point, std::size_t owner, std::vector<View>& views) {
  const auto ray = lens.unproject(point.pixel);
  if (!ray) return;
  const Eigen::Vector2d undistorted = ideal_pixel(lens, *ray);
  const Eigen::Vector3d normal = surface_normal(lens, undistorted, point.surface);
  if (-normal.dot(ray->normalized()) < kMinCosine) return;
  const double z = point.surface.depth_m;
  const double fine = std::log2(kFineness * 1e3 * z / std::sqrt(lens.fx * lens.fy));
  for (const int scale : {int(std::floor(fine)), int(std::floor(fine)) + 1})
    views.push_back(
        {owner, scale, point.pixel, image_from_view(lens, z * *ray, normal, 1e-3 * std::exp2(scale))});
}

}  // namespace

int hamming_distance(const SurfaceDescriptor& a, const SurfaceDescriptor& b) {
  int distance = 0;
  for (int i = 0; i < 4; ++i) distance += std::popcount(a.bits[i] ^ b.bits[i]);
  return distance;
}

int descriptor_distance(const std::vector<SurfaceDescriptor>& a, const std::vector<SurfaceDescriptor>& b) {
  int least = kNoDistance;
  for (const auto& x : a)
    for (const auto& y : b)
      if (x.scale == y.scale) least = std::min(least, hamming_distance(x, y));
  return least;
}

Eigen::Vector3d surface_normal(const Camera& camera, const Eigen::Vector2d& undistorted,
                               const PlaneDepth& surface) {
  // 1/z = a u + b v + c on the plane, so (a fx, b fy, a cx + b cy + c) . p = 1 for its points p.
  const Eigen::Vector2d& s = surface.slope_per_px;
  const double c = 1 / surface.depth_m - s.dot(undistorted);
  return -Eigen::Vector3d(s.x() * camera.fx, s.y() * camera.fy, s.x() * camera.cx + s.y() * camera.cy + c)
              .normalized();
}

std::vector<std::vector<SurfaceDescriptor>> describe_surfaces(const cv::Mat& gray, const Camera& lens,
                                                              const std::vector<SurfacePoint>& points) {
  std::vector<std::vector<SurfaceDescriptor>> result(points.size());
  std::vector<View> views;
  for (std::size_t i = 0; i < points.size(); ++i) add_views(lens, points[i], i, views);
  if (views.empty()) return result;
  Sheet sheet = draw_sheet(gray, views);
  const auto orb = cv::ORB::create(static_cast<int>(views.size()), 1.2F, 1, 31, 0, 2);
  cv::Mat bits;
  orb->compute(sheet.image, sheet.points, bits);
  if (bits.rows != static_cast<int>(views.size()) || bits.cols != 32)
    throw std::logic_error("ORB left out a view");
  for (std::size_t i = 0; i < views.size(); ++i) {
    SurfaceDescriptor descriptor;
    descriptor.scale = sheet.scales[i];
    std::memcpy(descriptor.bits.data(), bits.ptr(static_cast<int>(i)), 32);
    result[sheet.owners[i]].push_back(descriptor);
  }
  return result;
}

}  // namespace uniquadric
