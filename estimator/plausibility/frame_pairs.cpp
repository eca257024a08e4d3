#include "estimator/plausibility/frame_pairs.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/base/random.h"
#include "core/base/seconds.h"
#include "estimator/observation/ideal_ray.h"

namespace uniquadric {
namespace {

constexpr double kLongest_s = 0.35;     // between the frames of a pair, where there are nearer ones
constexpr double kLeastFollowed = 0.4;  // of the corners; fewer, and nearer frames are taken
constexpr int kLeastPoints = 20;

FrameImages read_images(const Sequence& sequence, const SequenceFrame& frame) {
  const cv::Mat depth = frame.depth.empty() ? cv::Mat() : read_depth(sequence, frame);
  return frame_images(read_rgb(sequence, frame), depth);
}

// The pair that begins at a frame; nothing where no frame after it shows enough of the same.
std::optional<FramePair> pair_from(const Sequence& sequence, std::size_t first) {
  const FrameImages a = read_images(sequence, sequence.frames[first]);
  const std::vector<PointPair> corners = corners_of(sequence.camera, a);
  if (std::ssize(corners) < kLeastPoints) return std::nullopt;
  for (const std::size_t gap : {8, 4, 2, 1}) {
    const std::size_t second = first + gap;
    if (second >= sequence.frames.size()) continue;
    const double time_s = seconds(sequence.frames[first].stamp_ns, sequence.frames[second].stamp_ns);
    if (gap > 1 && time_s > kLongest_s) continue;
    FramePair pair;
    pair.first = first;
    pair.second = second;
    pair.points = followed(sequence.camera, a, read_images(sequence, sequence.frames[second]), corners);
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
  RandomStream random(0, "plausibility", pair.first);
  const PairMotion motion = fit_motion(camera, pair.points, random);
  pair.b_from_a = motion.b_from_a;
  pair.share = motion.share;
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
