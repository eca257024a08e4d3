#include "estimator/perception/lidar_depth.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

cv::Point pixel_of(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
}

constexpr int kNobody = 0xffff;
constexpr double kForgotten_s = 0.5;  // without points, of a motion
constexpr int kTrustedFrames = 2;  // that a motion counts for: features fail for one frame without a reason

int label_at(const cv::Mat& masks, const Eigen::Vector2d& pixel) {
  if (masks.empty()) return 0;
  const cv::Point at = pixel_of(pixel);  // the image's outline itself rounds outwards
  return cv::Rect({}, masks.size()).contains(at) ? masks.at<std::uint16_t>(at) : kNobody;
}

// The part of the image whose depth somebody asks for: bodies and what may hide them.
cv::Rect around_bodies(const cv::Mat& masks, double margin_px) {
  std::vector<cv::Point> pixels;
  if (!masks.empty()) cv::findNonZero(masks != 0, pixels);
  if (pixels.empty()) return {};
  const int margin = static_cast<int>(margin_px);
  cv::Rect rect = cv::boundingRect(pixels);
  rect -= cv::Point(margin, margin);
  rect += cv::Size(2 * margin, 2 * margin);
  return rect & cv::Rect({}, masks.size());
}

// Rims of a mask belong to nobody: what a beam hits there may lie behind the body or on it.
cv::Mat without_rims(const cv::Mat& masks, int px) {
  if (masks.empty() || px == 0) return masks;
  const cv::Mat box = cv::getStructuringElement(cv::MORPH_RECT, {2 * px + 1, 2 * px + 1});
  cv::Mat least, most, result = masks.clone();
  cv::erode(masks, least, box);
  cv::dilate(masks, most, box);
  result.setTo(kNobody, least != most);
  return result;
}

}  // namespace

LidarDepth::LidarDepth(const Sequence& sequence, CameraPath path, const LidarDepthOptions& options)
    : camera_(sequence.camera),
      ideal_(without_distortion(sequence.camera)),
      camera_from_lidar_(sequence.lidar->camera_from_lidar),
      path_(std::move(path)),
      options_(options),
      stream_(sequence) {
  require_scans(sequence);
}

void LidarDepth::moved(int label, const Pose& world_motion, std::int64_t step_ns) {
  if (!finds_motions()) motions_[label] = {log_se3(world_motion) / seconds(0, step_ns)};
}

bool LidarDepth::finds_motions() const {
  return options_.motion == MotionSource::points && options_.undistortion == Undistortion::object;
}

Pose LidarDepth::told_motion(int label, double s) const {
  const auto told = motions_.find(label);
  if (label <= 0 || told == motions_.end() || options_.undistortion != Undistortion::object) return {};
  return exp_se3(told->second.twist * s);
}

void LidarDepth::advance(std::int64_t to_ns) {
  const double window_s =
      finds_motions() ? std::max(options_.window_s, options_.motion_window_s) : options_.window_s;
  std::erase_if(held_, [&](const Held& p) { return seconds(p.stamp_ns, to_ns) > window_s; });
  for (Held& p : held_) p.at_frame = told_motion(p.label, seconds(last_ns_, to_ns)) * p.at_frame;
  std::erase_if(twists_, [&](const auto& of) { return seconds(of.second.seen_ns, to_ns) > kForgotten_s; });
  for (auto& [label, found] : twists_) predict(found.twist, seconds(last_ns_, to_ns), options_.twist);
  before_last_ns_ = last_ns_;
  last_ns_ = to_ns;
}

// What bodies' points of different ages say of their motions.
void LidarDepth::find_motions(const Pose& camera_from_world) {
  std::map<int, std::vector<AgedPoint>> points;
  for (const Held& p : held_)
    if (p.label > 0) points[p.label].push_back({p.seen, seconds(p.stamp_ns, last_ns_)});
  for (const auto& [label, of_body] : points) {
    const auto [found, is_new] = twists_.try_emplace(label);
    if (is_new) found->second.twist = unknown_twist(of_body.front().world, options_.twist);
    found->second.seen_ns = last_ns_;
    update_by_points(found->second.twist, of_body, camera_from_world, ideal_, options_.twist);
  }
  for (Held& p : held_)
    if (p.label > 0)
      p.at_frame = moved_over(twists_.at(p.label).twist, seconds(p.stamp_ns, last_ns_)) * p.seen;  // Eq. 4
}

void LidarDepth::saw(const std::map<int, std::vector<Feature>>& features) {
  if (!finds_motions()) return;
  const auto now = path_(last_ns_), last = path_(before_last_ns_);
  std::map<std::int64_t, Eigen::Vector2d> pixels;
  for (const auto& [label, of_body] : features) {
    std::vector<PointStep> steps;
    for (const Feature& feature : of_body) {
      pixels[feature.track] = feature.pixel;
      const auto before = last_pixels_.find(feature.track);
      if (!now || before == last_pixels_.end() || feature.depth_m <= 0) continue;
      const Eigen::Vector3d ray = *ideal_.unproject(feature.pixel);
      steps.push_back({*now * (feature.depth_m * ray), before->second});
    }
    const auto found = twists_.find(label);
    if (!last || found == twists_.end() || before_last_ns_ >= last_ns_) continue;
    update_by_pixels(found->second.twist, steps, last->inverse(), seconds(before_last_ns_, last_ns_), ideal_,
                     options_.twist);
  }
  last_pixels_ = std::move(pixels);
}

void LidarDepth::receive(std::int64_t stamp_ns, std::int64_t until_ns, const Pose& world_from_camera,
                         const cv::Mat& masks) {
  const cv::Mat inner = without_rims(masks, options_.erode_px);
  const Pose camera_from_world = world_from_camera.inverse();
  for (const TimedPoint& p : stream_.take(until_ns)) {
    if (seconds(p.stamp_ns, stamp_ns) > options_.window_s) continue;
    const auto pose = options_.undistortion == Undistortion::none ? world_from_camera : path_(p.stamp_ns);
    if (!pose) continue;
    const Eigen::Vector3d in_lidar = p.lidar.cast<double>();
    const Eigen::Vector3d point = *pose * (camera_from_lidar_ * in_lidar);
    const auto pixel = camera_.project(camera_from_world * point);
    if (!pixel || !camera_.contains(*pixel)) continue;
    const int label = label_at(inner, *pixel);
    if (label == kNobody) continue;
    const Pose motion = told_motion(label, seconds(p.stamp_ns, stamp_ns));
    held_.push_back({p.stamp_ns, point, motion * point, in_lidar, label});
  }
}

LidarView LidarDepth::at(std::int64_t stamp_ns, std::int64_t next_stamp_ns, const cv::Mat& masks) {
  for (auto& [label, told] : motions_) ++told.frames;
  std::erase_if(motions_, [](const auto& motion) { return motion.second.frames > kTrustedFrames; });
  advance(stamp_ns);
  const auto world_from_camera = path_(stamp_ns);
  if (!world_from_camera) return {};
  receive(stamp_ns, stamp_ns + (next_stamp_ns - stamp_ns) / 2, *world_from_camera, masks);
  const Pose camera_from_world = world_from_camera->inverse();
  if (finds_motions()) find_motions(camera_from_world);
  const cv::Rect wanted = around_bodies(masks, options_.planes.reach_px);
  std::map<int, std::vector<ImagePoint>> samples;
  for (const Held& p : held_) {
    if (seconds(p.stamp_ns, stamp_ns) > options_.window_s) continue;
    const bool raw = options_.undistortion == Undistortion::none;
    const Eigen::Vector3d in_camera = raw ? camera_from_lidar_ * p.in_lidar : camera_from_world * p.at_frame;
    const auto pixel = camera_.project(in_camera);
    if (pixel && camera_.contains(*pixel) && wanted.contains(pixel_of(*pixel)) &&
        label_at(masks, *pixel) == p.label)
      samples[p.label].push_back({*pixel, 1 / in_camera.z()});
  }
  LidarView view{cv::Mat::zeros(camera_.height, camera_.width, CV_32FC1), {}};
  for (const auto& [label, points] : samples) {
    PointPlaneOptions options = options_.planes;
    options.one_body = label > 0;
    const std::vector<PointPlane> planes = point_planes(points, options);
    fill_depth(planes, label, masks, options_.planes.reach_px, view.depth);
    if (label > 0) view.bodies[label] = surface_points(planes, camera_, options_.max_points);
  }
  return view;
}

}  // namespace uniquadric
