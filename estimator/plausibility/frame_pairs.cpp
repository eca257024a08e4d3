#include "estimator/plausibility/frame_pairs.h"

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/seconds.h"
#include "estimator/features/corners.h"
#include "estimator/features/point_flow.h"
#include "estimator/images/plane_depth.h"
#include "estimator/images/rigid_motion.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr int kCorners = 300;
constexpr double kSpacing = 1.0 / 40;   // of the image's width, between corners
constexpr int kFastThreshold = 8;       // grey levels, as of the tracker
constexpr double kLongest_s = 0.35;     // between the frames of a pair, where there are nearer ones
constexpr double kLeastFollowed = 0.4;  // of the corners; fewer, and nearer frames are taken
constexpr int kLeastPoints = 20;
constexpr double kLeastShare = 0.3;  // of the points with depth, that one motion explains

struct View {
  cv::Mat gray, depth;
};

View read_view(const Sequence& sequence, const SequenceFrame& frame) {
  View view;
  cv::cvtColor(read_rgb(sequence, frame), view.gray, cv::COLOR_BGR2GRAY);
  if (!frame.depth.empty()) view.depth = read_depth(sequence, frame);
  return view;
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

// The undistorted pixel, in the matrix of the same camera.
std::optional<Eigen::Vector2d> undistorted(const Camera& camera, const Eigen::Vector2d& raw) {
  const auto ray = camera.unproject(raw);
  if (!ray) return std::nullopt;
  return ideal_pixel(camera, *ray);
}

void read_off_depth(const cv::Mat& depth, const Eigen::Vector2d& raw, double& depth_m, double& sigma_m) {
  if (depth.empty()) return;
  const auto plane = fit_plane_depth(depth, {}, raw, {});
  if (!plane) return;
  depth_m = plane->depth_m;
  sigma_m = plane->sigma_m;
}

// Corners of a that are found in b.
std::vector<PointPair> followed(const Camera& camera, const View& a, const View& b,
                                const std::vector<Eigen::Vector2d>& corners) {
  const PointFlowOptions options;
  const auto found = follow_points(make_flow_image(a.gray, options), make_flow_image(b.gray, options),
                                   corners, corners, options);
  std::vector<PointPair> points;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    if (!found[i]) continue;
    const auto ideal_a = undistorted(camera, corners[i]), ideal_b = undistorted(camera, *found[i]);
    if (!ideal_a || !ideal_b) continue;
    PointPair& point = points.emplace_back();
    point.raw_a = corners[i], point.raw_b = *found[i];
    point.a = *ideal_a, point.b = *ideal_b;
    read_off_depth(a.depth, point.raw_a, point.depth_a_m, point.sigma_a_m);
    read_off_depth(b.depth, point.raw_b, point.depth_b_m, point.sigma_b_m);
  }
  return points;
}

// The pair that begins at a frame; nothing where no frame after it shows enough of the same.
std::optional<FramePair> pair_from(const Sequence& sequence, std::size_t first) {
  const View a = read_view(sequence, sequence.frames[first]);
  const std::vector<Eigen::Vector2d> corners = spread_corners(a.gray);
  if (std::ssize(corners) < kLeastPoints) return std::nullopt;
  for (const std::size_t gap : {8, 4, 2, 1}) {
    const std::size_t second = first + gap;
    if (second >= sequence.frames.size()) continue;
    const double time_s = seconds(sequence.frames[first].stamp_ns, sequence.frames[second].stamp_ns);
    if (gap > 1 && time_s > kLongest_s) continue;
    FramePair pair;
    pair.first = first;
    pair.second = second;
    pair.points = followed(sequence.camera, a, read_view(sequence, sequence.frames[second]), corners);
    const double least = std::max<double>(kLeastPoints, kLeastFollowed * static_cast<double>(corners.size()));
    if (static_cast<double>(pair.points.size()) < least) continue;
    fit_pair(sequence.camera, pair);
    return pair;
  }
  return std::nullopt;
}

}  // namespace

std::optional<Eigen::Vector2d> moved_pixel(const PointPair& point, const Camera& camera,
                                           const Pose& b_from_a) {
  if (!(point.depth_a_m > 0)) return std::nullopt;
  const Eigen::Vector3d p = b_from_a * (point.depth_a_m * ideal_ray(camera, point.a));
  if (!(p.z() > 0.01)) return std::nullopt;
  return Eigen::Vector2d(camera.fx * p.x() / p.z() + camera.cx, camera.fy * p.y() / p.z() + camera.cy);
}

void fit_pair(const Camera& camera, FramePair& pair) {
  std::vector<PointSighting> sightings;
  std::vector<PointPair*> sources;
  for (PointPair& point : pair.points) {
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
  RandomStream random(0, "plausibility", pair.first);
  const auto fit = fit_rigid_motion(sightings, without_distortion(camera), std::nullopt, options, random);
  pair.b_from_a.reset();
  pair.share = 0;
  if (!fit) return;
  for (std::size_t i = 0; i < sources.size(); ++i) sources[i]->is_inlier = fit->inlier[i];
  pair.share = static_cast<double>(fit->inliers) / static_cast<double>(sources.size());
  if (fit->inliers >= kLeastPoints / 2 && pair.share >= kLeastShare) pair.b_from_a = fit->camera_from_body;
}

std::vector<FramePair> frame_pairs(const Sequence& sequence, int pairs) {
  std::vector<FramePair> result;
  const std::size_t frames = sequence.frames.size();
  const std::size_t wanted = std::min<std::size_t>(pairs, frames > 0 ? frames - 1 : 0);
  for (std::size_t i = 0; i < wanted; ++i) {
    try {
      if (auto pair = pair_from(sequence, i * (frames - 1) / wanted)) result.push_back(std::move(*pair));
    } catch (const InputError&) {  // is told by who reads all images
    }
  }
  return result;
}

}  // namespace uniquadric
