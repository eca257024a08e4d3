#include "estimator/lidar/frame_points.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <utility>

#include "core/base/seconds.h"

namespace uniquadric {
namespace {

constexpr int kNobody = 0xffff;

cv::Point pixel_of(const Eigen::Vector2d& pixel) {
  return {static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y()))};
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

}  // namespace

int label_at(const cv::Mat& masks, const Eigen::Vector2d& pixel) {
  if (masks.empty()) return 0;
  const cv::Point at = pixel_of(pixel);  // the image's outline itself rounds outwards
  return cv::Rect({}, masks.size()).contains(at) ? masks.at<std::uint16_t>(at) : kNobody;
}

FramePointSource::FramePointSource(const Sequence& sequence, CameraPath path,
                                   const FramePointOptions& options)
    : camera_(sequence.camera),
      camera_from_lidar_(sequence.lidar->camera_from_lidar),
      path_(std::move(path)),
      options_(options),
      stream_(sequence) {
  require_scans(sequence);
}

void FramePointSource::receive(std::int64_t until_ns, const cv::Mat& masks, FramePoints& frame) {
  const cv::Mat inner = without_rims(masks, options_.erode_px);
  const Pose camera_from_world = frame.world_from_camera->inverse();
  for (const TimedPoint& p : stream_.take(until_ns)) {
    if (seconds(p.stamp_ns, frame.stamp_ns) > options_.window_s) continue;
    const auto pose =
        options_.undistortion == Undistortion::none ? frame.world_from_camera : path_(p.stamp_ns);
    if (!pose) continue;
    const Eigen::Vector3d in_lidar = p.lidar.cast<double>();
    const Eigen::Vector3d point = *pose * (camera_from_lidar_ * in_lidar);
    const auto pixel = camera_.project(camera_from_world * point);
    if (!pixel || !camera_.contains(*pixel)) continue;
    const int label = label_at(inner, *pixel);
    if (label == 0)
      background_.push_back({p.stamp_ns, point, in_lidar, label});
    else if (label != kNobody)
      frame.on_bodies.push_back({p.stamp_ns, point, in_lidar, label});
  }
}

void FramePointSource::keep_background(const cv::Mat& masks, FramePoints& frame) const {
  const cv::Rect wanted = around_bodies(masks, options_.reach_px);
  const Pose camera_from_world = frame.world_from_camera->inverse();
  const bool raw = options_.undistortion == Undistortion::none;
  for (const LabelledPoint& p : background_) {
    const Eigen::Vector3d in_camera = raw ? camera_from_lidar_ * p.in_lidar : camera_from_world * p.seen;
    const auto pixel = camera_.project(in_camera);
    if (pixel && camera_.contains(*pixel) && wanted.contains(pixel_of(*pixel)) &&
        label_at(masks, *pixel) == 0)
      frame.background.push_back({*pixel, 1 / in_camera.z()});
  }
}

FramePoints FramePointSource::take(std::int64_t stamp_ns, std::int64_t next_stamp_ns, const cv::Mat& masks) {
  FramePoints frame{stamp_ns, std::exchange(last_ns_, stamp_ns), path_(stamp_ns), {}, {}, {}};
  frame.world_from_last = path_(frame.last_stamp_ns);
  std::erase_if(background_,
                [&](const LabelledPoint& p) { return seconds(p.stamp_ns, stamp_ns) > options_.window_s; });
  if (!frame.world_from_camera) return frame;
  receive(stamp_ns + (next_stamp_ns - stamp_ns) / 2, masks, frame);
  keep_background(masks, frame);
  return frame;
}

}  // namespace uniquadric
