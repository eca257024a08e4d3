#include "estimator/features/frame_pair.h"

#include <cmath>
#include <opencv2/imgproc.hpp>

#include "estimator/features/corners.h"
#include "estimator/features/point_flow.h"
#include "estimator/images/plane_depth.h"
#include "estimator/images/rigid_motion.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr int kCorners = 300;
constexpr double kSpacing = 1.0 / 40;  // of the image's width, between corners
constexpr int kFastThreshold = 8;      // grey levels, as of the tracker
constexpr int kLeastInliers = 10;
constexpr double kLeastShare = 0.3;  // of the points with depth, that one motion explains

// The undistorted pixel, in the matrix of the same camera.
std::optional<Eigen::Vector2d> undistorted(const Camera& camera, const Eigen::Vector2d& raw) {
  const auto ray = camera.unproject(raw);
  if (!ray) return std::nullopt;
  return ideal_pixel(camera, *ray);
}

void read_off_depth(const cv::Mat& depth, const Eigen::Vector2d& raw, double& depth_m, double& sigma_m) {
  const auto plane = depth.empty() ? std::nullopt : fit_plane_depth(depth, {}, raw, {});
  depth_m = plane ? plane->depth_m : 0;
  sigma_m = plane ? plane->sigma_m : 0;
}

std::vector<Eigen::Vector2d> spread_corners(const cv::Mat& gray) {
  Spacing spacing(gray.size());
  std::vector<Eigen::Vector2d> chosen;
  for (const Corner& corner : fast_corners(gray, kFastThreshold)) {
    if (std::ssize(chosen) >= kCorners) break;
    if (!spacing.is_free(corner.pixel)) continue;
    spacing.take(corner.pixel, kSpacing * gray.cols);
    chosen.push_back(corner.pixel);
  }
  return chosen;
}

}  // namespace

FrameImages frame_images(const cv::Mat& rgb, const cv::Mat& depth) {
  FrameImages images{{}, depth};
  cv::cvtColor(rgb, images.gray, cv::COLOR_BGR2GRAY);
  return images;
}

std::vector<PointPair> corners_of(const Camera& camera, const FrameImages& image) {
  std::vector<PointPair> points;
  for (const Eigen::Vector2d& corner : spread_corners(image.gray)) {
    const auto ideal = undistorted(camera, corner);
    if (!ideal) continue;
    PointPair& point = points.emplace_back();
    point.raw_a = point.raw_b = corner;
    point.a = point.b = *ideal;
    read_off_depth(image.depth, corner, point.depth_a_m, point.sigma_a_m);
    point.depth_b_m = point.depth_a_m, point.sigma_b_m = point.sigma_a_m;
  }
  return points;
}

std::vector<PointPair> followed(const Camera& camera, const FrameImages& b, const FrameImages& next,
                                const std::vector<PointPair>& points) {
  std::vector<Eigen::Vector2d> pixels;
  for (const PointPair& point : points) pixels.push_back(point.raw_b);
  const PointFlowOptions options;
  const auto found = follow_points(make_flow_image(b.gray, options), make_flow_image(next.gray, options),
                                   pixels, pixels, options);
  std::vector<PointPair> result;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto ideal = found[i] ? undistorted(camera, *found[i]) : std::nullopt;
    if (!ideal) continue;
    PointPair& point = result.emplace_back(points[i]);
    point.raw_b = *found[i];
    point.b = *ideal;
    read_off_depth(next.depth, point.raw_b, point.depth_b_m, point.sigma_b_m);
  }
  return result;
}

PairMotion fit_motion(const Camera& camera, std::vector<PointPair>& points, RandomStream& random) {
  std::vector<PointSighting> sightings;
  std::vector<PointPair*> sources;
  for (PointPair& point : points) {
    point.is_inlier = false;
    if (!(point.depth_a_m > 0 && point.depth_b_m > 0)) continue;
    const double sigma_m = std::hypot(point.sigma_a_m, point.sigma_b_m);
    sightings.push_back({point.depth_a_m * ideal_ray(camera, point.a), point.b, point.depth_b_m, sigma_m});
    sources.push_back(&point);
  }
  RigidMotionOptions options;
  options.pixel_gate = 2;
  options.pixel_sigma = 0.3;
  options.min_share = 0;
  options.depth_gate = 4;
  const auto fit = fit_rigid_motion(sightings, without_distortion(camera), std::nullopt, options, random);
  PairMotion motion;
  if (!fit) return motion;
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i]->is_inlier = fit->inlier[i];
  motion.share = static_cast<double>(fit->inliers) / static_cast<double>(sources.size());
  if (fit->inliers >= kLeastInliers && motion.share >= kLeastShare) motion.b_from_a = fit->camera_from_body;
  return motion;
}

}  // namespace uniquadric
