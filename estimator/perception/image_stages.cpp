#include "estimator/perception/image_stages.h"

#include <fmt/format.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/warning.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/perception/depth_bias.h"
#include "estimator/perception/observe_bodies.h"
#include "estimator/segmentation/check_sequence.h"

namespace uniquadric {
namespace {

std::optional<Pose> pose_at(const std::map<std::int64_t, Pose>& poses, std::int64_t stamp_ns) {
  const auto pose = poses.find(stamp_ns);
  return pose == poses.end() ? std::nullopt : std::optional(pose->second);
}

std::map<std::int64_t, Pose> given_poses(const Sequence& sequence) {
  if (!sequence.given_camera || sequence.given_camera->empty())
    throw InputError(sequence.folder / "camera_given.tum",
                     "holds no camera poses, which the variant (ego: given) needs");
  return by_stamp(*sequence.given_camera);
}

// The tracker, where the options want one.
std::unique_ptr<AsyncObjectTracker> make_tracker(const Sequence& sequence, const PromptedSegmenter& segmenter,
                                                 AotOptions options, std::uint64_t seed) {
  if (!options.enabled) return nullptr;
  options.trust_ids = options.trust_ids || segmenter.names_bodies;
  return std::make_unique<AsyncObjectTracker>(sequence.camera,
                                              slow_segmenter(sequence, segmenter, options, seed), options);
}

bool has_depth_images(const Sequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(),
                     [](const SequenceFrame& frame) { return !frame.depth.empty(); });
}

// Points are put together along the camera's path, which features that wait for their depth cannot give.
bool wants_lidar_depth(const Sequence& sequence, const PerceptionOptions& options) {
  const bool can = sequence.lidar && options.ego != EgoSource::rgbd;
  if (options.depth == DepthSource::lidar && !can)
    throw InputError(sequence.folder, sequence.lidar
                                          ? "the variant takes depth from the LiDAR (depth: lidar) and the "
                                            "camera's motion from depth (ego: rgbd); use ego: lidar"
                                          : "has no LiDAR, which the variant (depth: lidar) needs");
  return options.depth == DepthSource::lidar ||
         (options.depth == DepthSource::recorded && can && !has_depth_images(sequence));
}

// Between the poses of the frames; nothing outside.
std::optional<Pose> pose_between(const std::map<std::int64_t, Pose>& poses, std::int64_t stamp_ns) {
  const auto after = poses.lower_bound(stamp_ns);
  if (after == poses.end()) return std::nullopt;
  if (after->first == stamp_ns) return after->second;
  if (after == poses.begin()) return std::nullopt;
  const auto before = std::prev(after);
  const double gone = static_cast<double>(stamp_ns - before->first);
  return interpolate(before->second, after->second, gone / static_cast<double>(after->first - before->first));
}

// What the features say of how bodies moved goes to the LiDAR's depth of the next frame.
void tell_motions(const TrackedFeatures& tracked, const FramePoints& frame, LidarDepth& lidar) {
  for (const auto& [label, motion] : tracked.motions)
    lidar.moved(label, *frame.world_from_camera * motion * frame.world_from_last->inverse(),
                frame.stamp_ns - frame.last_stamp_ns);
}

bool is_same_image(const cv::Mat& a, const cv::Mat& b) {
  if (a.size() != b.size() || a.type() != b.type()) return false;
  for (int v = 0; v < a.rows; ++v)
    if (!std::equal(a.ptr(v), a.ptr(v) + a.cols * a.elemSize(), b.ptr(v))) return false;
  return true;
}

// When the frame after this one comes; after the last one as long as before it.
std::int64_t next_stamp_ns(const Sequence& sequence, std::size_t index) {
  const auto& frames = sequence.frames;
  if (index + 1 < frames.size()) return frames[index + 1].stamp_ns;
  return index == 0 ? frames[0].stamp_ns : 2 * frames[index].stamp_ns - frames[index - 1].stamp_ns;
}

void add_features(const TrackedFeatures& tracked, PerceivedFrame& frame) {
  for (const auto& [id, features] : tracked.bodies) body_of(frame, id).features = features;
  for (const auto& [id, motion] : tracked.motions) body_of(frame, id).motion = motion;
}

// A late outline goes to the frame that it is of. A body that was not tracked there had no pose, and its
// outline says nothing without.
void add_late_outlines(std::vector<LateOutlines>& late, std::deque<PerceivedFrame>& frames) {
  for (auto& [number, silhouettes] : late)
    for (PerceivedFrame& frame : frames) {
      if (frame.frame != number) continue;
      for (BodyObservation& body : frame.bodies) {
        const auto found = silhouettes.find(body.id);
        if (found == silhouettes.end()) continue;
        const bool is_late = found->second.known_at_frame > frame.frame;
        (is_late ? body.segmented : body.silhouette) = std::move(found->second);
      }
    }
}

}  // namespace

ImageInput prepare_images(const Sequence& recorded, const PerceptionOptions& options,
                          const PerceiveOptions& run, std::vector<StageTime>& times) {
  ImageInput input;
  input.sequence = on_camera_clock(recorded, options.lidar_time_offset_ns);
  Sequence& sequence = input.sequence;
  if (options.ego == EgoSource::given) input.poses = given_poses(sequence);
  input.segmenter = make_segmenter(sequence, options.segmentation, run.prompts);
  check_sequence(sequence, input.segmenter, input.poses, options.ego == EgoSource::lidar,
                 options.depth == DepthSource::images);
  if (options.drop_smeared_edges) sequence.depth_edge_width_px = depth_edge_width_px(sequence);
  if (options.depth_calibration && has_depth_images(sequence) && !wants_lidar_depth(sequence, options)) {
    Stopwatch watch(sequence.frames.front().frame, times);
    input.bias = depth_bias(sequence, options, input.segmenter.source == kSequenceMasks, run);
    sequence.inverse_depth_bias_per_m = input.bias ? input.bias->per_m : 0;
    watch.stop("calibration");
  }
  return input;
}

ImageStages::ImageStages(const ImageInput& input, const PerceptionOptions& options,
                         const PerceiveOptions& run, PerceptionWriter& out)
    : input_(input),
      sequence_(input.sequence),
      options_(options),
      run_(run),
      out_(out),
      features_(sequence_.camera, options.features, run.seed, sequence_.rolling_shutter_s),
      odometry_(sequence_.camera, options.odometry, run.seed, options.fixed_lag_s,
                options.features.rolling_shutter.enabled ? sequence_.rolling_shutter_s : 0),
      depth_check_(options.depth_check),
      progress_("perceive", std::ssize(sequence_.frames), run.quiet) {
  if (keeps_masks()) std::filesystem::create_directories(run.masks_folder);
  if (options.ego == EgoSource::lidar) lidar_.emplace(sequence_, options.lidar);
  tracker_ = make_tracker(sequence_, input.segmenter, options.aot, run.seed);
  if (!wants_lidar_depth(sequence_, options)) return;
  points_.emplace(
      sequence_, [this](std::int64_t stamp_ns) { return camera_at(stamp_ns); },
      frame_point_options(options.lidar_depth));
  lidar_depth_.emplace(sequence_, options.lidar_depth);
}

// By the LiDAR or given, between frames too.
std::optional<Pose> ImageStages::camera_at(std::int64_t stamp_ns) const {
  return lidar_ ? lidar_->odometry().world_from_camera(stamp_ns) : pose_between(*input_.poses, stamp_ns);
}

bool ImageStages::keeps_masks() const {
  const std::string& source = input_.segmenter.source;
  return !run_.masks_folder.empty() && source != kSequenceMasks && source != kNoMasks;
}

void ImageStages::read(FrameWork& work) const {
  const SequenceFrame& frame = sequence_.frames[work.index];
  work.result.frame = frame.frame;
  work.result.stamp_ns = frame.stamp_ns;
  Stopwatch watch(frame.frame, work.times);
  work.rgb = read_rgb(sequence_, frame);
  if (!frame.depth.empty()) work.depth = read_depth(sequence_, frame);
  watch.stop("read");
}

void ImageStages::refuse_depth(FrameWork& work) {
  // another one: the tracker of masks keeps that which it saw
  work.depth = cv::Mat(work.depth.size(), work.depth.type(), cv::Scalar(0));
  work.surfaces.clear();
  work.result.depth_refused = true;
  ++unusable_;
}

void ImageStages::check_depth(FrameWork& work) {
  repeats_.add(work.result.frame, is_same_image(work.rgb, last_rgb_));
  last_rgb_ = work.rgb;
  if (work.depth.empty()) return;
  ++depth_images_;
  if (cv::countNonZero(work.depth) == 0) {
    work.result.depth_refused = true;
    ++blank_;
  } else if (!depth_check_.is_measurement(work.result.stamp_ns, work.depth)) {
    refuse_depth(work);
  }
}

void ImageStages::segment_now(FrameWork& work) const {
  if (tracker_) return;
  const SequenceFrame& frame = sequence_.frames[work.index];
  Stopwatch watch(frame.frame, work.times);
  work.masks = segment(input_.segmenter, sequence_, frame, work.depth, run_.seed);
  watch.stop("segment");
  work.result.has_masks = !work.masks.empty();
}

void ImageStages::carry_masks(FrameWork& work) {
  if (!tracker_) return;
  AotFrame tracked = tracker_->track(sequence_.frames[work.index], work.rgb, work.depth,
                                     next_stamp_ns(sequence_, work.index));
  work.masks = tracked.masks;
  work.arrived = std::move(tracked.arrived);
  work.oldest_pending = tracked.oldest_pending;
  work.result.has_masks = tracked.has_masks;
  work.times.insert(work.times.end(), tracked.times.begin(), tracked.times.end());
}

void ImageStages::place_camera(FrameWork& work) {
  const SequenceFrame& frame = sequence_.frames[work.index];
  Stopwatch watch(frame.frame, work.times);
  if (lidar_) {
    lidar_->track(frame, work.masks);
    watch.stop("ego");
    work.world_from_camera = camera_at(frame.stamp_ns);
  } else if (input_.poses) {
    work.world_from_camera = pose_at(*input_.poses, frame.stamp_ns);
  }
  if (work.world_from_camera) known_.push_back({frame.stamp_ns, *work.world_from_camera});
  if (!points_) return;
  work.points = points_->take(frame.stamp_ns, next_stamp_ns(sequence_, work.index), work.masks);
  watch.stop("lidar_depth");
}

void ImageStages::add_background_depth(FrameWork& work) const {
  if (!lidar_depth_) return;
  Stopwatch watch(work.result.frame, work.times);
  work.depth = lidar_depth_->background(work.points, work.masks);
  watch.stop("lidar_depth");
}

void ImageStages::add_lidar_depth(FrameWork& work) {
  Stopwatch watch(work.result.frame, work.times);
  LidarView view = lidar_depth_->at(work.points, work.masks, work.depth);
  work.depth = std::move(view.depth);
  work.surfaces = std::move(view.bodies);
  watch.stop("lidar_depth");
}

void ImageStages::follow_features(FrameWork& work) {
  const SequenceFrame& frame = sequence_.frames[work.index];
  if (lidar_depth_) add_lidar_depth(work);
  Stopwatch watch(frame.frame, work.times);
  BodyHints hints;
  if (run_.feedback) hints = run_.feedback->hints(frame.frame, frame.stamp_ns);
  const TrackedFeatures tracked = features_.track(frame, work.rgb, work.depth, work.masks, hints);
  if (tracked.depth_refused) refuse_depth(work);
  work.result.depth_changed = tracked.depth_changed;
  add_features(tracked, work.result);
  watch.stop("features");
  if (lidar_depth_) lidar_depth_->saw(tracked.bodies);
  if (lidar_depth_ && work.points.world_from_camera && work.points.world_from_last)
    tell_motions(tracked, work.points, *lidar_depth_);
  const bool by_features = options_.ego == EgoSource::rgbd;
  if (by_features) {
    odometry_.track(frame, tracked, work.depth, work.masks);
    watch.stop("ego");
  }
  if (run_.feedback) work.result.world_from_camera = by_features ? odometry_.pose() : work.world_from_camera;
}

void ImageStages::observe(FrameWork& work) const {
  if (keeps_masks() && !work.masks.empty())
    write_png(run_.masks_folder / fmt::format("{:06}.png", work.result.frame), work.masks);
  observe_bodies(sequence_.camera, options_, run_.seed, work);
  std::ranges::sort(work.result.bodies, {}, &BodyObservation::id);
}

void ImageStages::hand_over(FrameWork& work, std::vector<StageTime>& times) {
  times.insert(times.end(), work.times.begin(), work.times.end());
  waiting_.push_back(std::move(work.result));
  add_late_outlines(work.late, waiting_);
  if (run_.feedback) {
    Stopwatch watch(waiting_.back().frame, times);
    run_.feedback->take(waiting_.back());
    watch.stop("feedback");
  }
  for (; !waiting_.empty() && (!tracker_ || waiting_.front().frame < work.oldest_pending);
       waiting_.pop_front())
    out_.add(waiting_.front());
  progress_.advance();
}

void ImageStages::say_faults() const {
  if (unusable_ > 0)
    warn(fmt::format("{} depth images are no measurements: they have one value, or jump as a whole",
                     unusable_.load()));
  if (blank_ > 0) warn(fmt::format("{} of {} depth images hold no depth at all", blank_, depth_images_));
  if (const auto runs = repeats_.text())
    warn(fmt::format("frames {} have the same colour image, as of a camera that froze", *runs));
  warn_of_prompts(input_.segmenter);
}

void ImageStages::finish() {
  say_faults();
  if (lidar_) {
    lidar_->finish();
    out_.keep_map(lidar_->odometry().map_points());
  }
  std::vector<std::string> faults;
  if (lidar_)
    faults = lidar_->scan_faults();
  else if (points_)
    faults = points_->watch().faults(sequence_.lidar->rate_hz);
  for (const std::string& fault : faults) warn(fault);
  for (const PerceivedFrame& frame : waiting_) out_.add(frame);
  const Trajectory later = lidar_ ? lidar_->trajectory() : known_;
  // a filter never goes back to a pose
  CameraTrajectories cameras{known_, later, later};
  if (options_.ego == EgoSource::rgbd)
    cameras = {odometry_.causal_trajectory(), odometry_.lagged_trajectory(), odometry_.trajectory()};
  out_.finish(cameras, odometry_.restarts(), input_.bias, sequence_.depth_edge_width_px);
}

}  // namespace uniquadric
