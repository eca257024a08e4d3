#include "estimator/lidar/lidar_depth.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr double kForgotten_s = 0.5;  // without points, of a motion
constexpr int kTrustedFrames = 2;  // that a motion counts for: features fail for one frame without a reason

}  // namespace

FramePointOptions frame_point_options(const LidarDepthOptions& options) {
  return {options.undistortion, options.window_s, options.erode_px, options.planes.reach_px};
}

LidarDepth::LidarDepth(const Sequence& sequence, const LidarDepthOptions& options)
    : camera_(sequence.camera),
      ideal_(without_distortion(sequence.camera)),
      camera_from_lidar_(sequence.lidar->camera_from_lidar),
      options_(options) {}

void LidarDepth::moved(int label, const Pose& world_motion, std::int64_t step_ns) {
  if (!finds_motions()) motions_[label] = {log_se3(world_motion) / seconds(0, step_ns)};
}

bool LidarDepth::finds_motions() const {
  return options_.motion == MotionSource::points && options_.undistortion == Undistortion::object;
}

Pose LidarDepth::told_motion(int label, double s) const {
  const auto told = motions_.find(label);
  if (told == motions_.end() || options_.undistortion != Undistortion::object) return {};
  return exp_se3(told->second.twist * s);
}

void LidarDepth::advance(std::int64_t to_ns) {
  const double window_s =
      finds_motions() ? std::max(options_.window_s, options_.motion_window_s) : options_.window_s;
  std::erase_if(held_, [&](const Held& p) { return seconds(p.point.stamp_ns, to_ns) > window_s; });
  for (Held& p : held_) p.at_frame = told_motion(p.point.label, seconds(last_ns_, to_ns)) * p.at_frame;
  std::erase_if(twists_, [&](const auto& of) { return seconds(of.second.seen_ns, to_ns) > kForgotten_s; });
  for (auto& [label, found] : twists_) predict(found.twist, seconds(last_ns_, to_ns), options_.twist);
  before_last_ns_ = last_ns_;
  last_ns_ = to_ns;
}

// What bodies' points of different ages say of their motions.
void LidarDepth::find_motions(const Pose& camera_from_world) {
  std::map<int, std::vector<AgedPoint>> points;
  for (const auto& [p, at_frame] : held_) points[p.label].push_back({p.seen, seconds(p.stamp_ns, last_ns_)});
  for (const auto& [label, of_body] : points) {
    const auto [found, is_new] = twists_.try_emplace(label);
    if (is_new) found->second.twist = unknown_twist(of_body.front().world, options_.twist);
    found->second.seen_ns = last_ns_;
    update_by_points(found->second.twist, of_body, camera_from_world, ideal_, options_.twist);
  }
  for (auto& [p, at_frame] : held_)
    at_frame = moved_over(twists_.at(p.label).twist, seconds(p.stamp_ns, last_ns_)) * p.seen;  // Eq. 4
}

void LidarDepth::saw(const std::map<int, std::vector<Feature>>& features) {
  if (!finds_motions()) return;
  std::map<std::int64_t, Eigen::Vector2d> pixels;
  for (const auto& [label, of_body] : features) {
    std::vector<PointStep> steps;
    for (const Feature& feature : of_body) {
      pixels[feature.track] = feature.pixel;
      const auto before = last_pixels_.find(feature.track);
      if (!last_ || before == last_pixels_.end() || feature.depth_m <= 0) continue;
      const Eigen::Vector3d ray = *ideal_.unproject(feature.pixel);
      steps.push_back({*last_ * (feature.depth_m * ray), before->second});
    }
    const auto found = twists_.find(label);
    if (!before_last_ || found == twists_.end() || before_last_ns_ >= last_ns_) continue;
    update_by_pixels(found->second.twist, steps, before_last_->inverse(), seconds(before_last_ns_, last_ns_),
                     ideal_, options_.twist);
  }
  last_pixels_ = std::move(pixels);
}

cv::Mat LidarDepth::background(const FramePoints& points, const cv::Mat& masks) const {
  if (!points.world_from_camera) return {};
  cv::Mat depth = cv::Mat::zeros(camera_.height, camera_.width, CV_32FC1);
  PointPlaneOptions options = options_.planes;
  options.one_body = false;
  fill_depth(point_planes(points.background, options), 0, masks, options.reach_px, depth);
  return depth;
}

LidarView LidarDepth::at(const FramePoints& points, const cv::Mat& masks, cv::Mat depth) {
  for (auto& [label, told] : motions_) ++told.frames;
  std::erase_if(motions_, [](const auto& motion) { return motion.second.frames > kTrustedFrames; });
  advance(points.stamp_ns);
  last_ = points.world_from_camera, before_last_ = points.world_from_last;
  if (!last_) return {};
  for (const LabelledPoint& p : points.on_bodies)
    held_.push_back({p, told_motion(p.label, seconds(p.stamp_ns, last_ns_)) * p.seen});
  const Pose camera_from_world = last_->inverse();
  if (finds_motions()) find_motions(camera_from_world);
  LidarView view{std::move(depth), {}};
  for (const auto& [label, of_body] : samples(camera_from_world, masks)) {
    PointPlaneOptions options = options_.planes;
    options.one_body = true;
    const std::vector<PointPlane> planes = point_planes(of_body, options);
    fill_depth(planes, label, masks, options_.planes.reach_px, view.depth);
    view.bodies[label] = surface_points(planes, camera_, options_.max_points);
  }
  return view;
}

// Points of the window where they are now, as the image shows them.
std::map<int, std::vector<ImagePoint>> LidarDepth::samples(const Pose& camera_from_world,
                                                           const cv::Mat& masks) const {
  const bool raw = options_.undistortion == Undistortion::none;
  std::map<int, std::vector<ImagePoint>> result;
  for (const auto& [point, at_frame] : held_) {
    if (seconds(point.stamp_ns, last_ns_) > options_.window_s) continue;
    const Eigen::Vector3d in_camera =
        raw ? camera_from_lidar_ * point.in_lidar : camera_from_world * at_frame;
    const auto pixel = camera_.project(in_camera);
    if (pixel && camera_.contains(*pixel) && label_at(masks, *pixel) == point.label)
      result[point.label].push_back({*pixel, 1 / in_camera.z()});
  }
  return result;
}

}  // namespace uniquadric
