#include "estimator/perception/perceive.h"

#include <fmt/format.h>
#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <atomic>
#include <deque>
#include <memory>
#include <opencv2/imgproc.hpp>

#include "core/base/error.h"
#include "core/base/progress.h"
#include "core/base/threads.h"
#include "core/base/warning.h"
#include "estimator/perception/check_sequence.h"
#include "estimator/perception/depth_bias.h"
#include "estimator/perception/lidar_stream.h"
#include "estimator/perception/point_colors.h"
#include "estimator/perception/repeats.h"
#include "estimator/perception/scan_watch.h"
#include "estimator/stopwatch.h"

namespace uniquadric {
namespace {

constexpr int kFramesInFlight = 4;  // more cost memory and gain nothing on two cores

// The outlines of a segmenter's result for an earlier frame.
struct LateOutlines {
  std::int64_t frame = 0;
  std::map<int, Silhouette> silhouettes;
};

// What passes through the pipeline.
struct Work {
  std::size_t index = 0;
  cv::Mat rgb, depth, masks;
  std::optional<Pose> world_from_camera;  // as it is known by now, but from features
  FramePoints points;                     // of the LiDAR, where the depth is its
  std::map<int, SurfacePoints> surfaces;  // of the bodies, by these
  std::vector<AotFrame::Arrived> arrived;
  PerceivedFrame result;
  std::vector<LateOutlines> late;
  std::int64_t oldest_pending = 0;  // for no frame before it will there be any more of these
  std::vector<StageTime> times;
};

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

BodyObservation& body_of(PerceivedFrame& frame, int id) {
  for (BodyObservation& body : frame.bodies)
    if (body.id == id) return body;
  frame.bodies.emplace_back().id = id;
  return frame.bodies.back();
}

std::set<int> ids_in(const cv::Mat& masks) {
  std::set<int> ids;
  for (int v = 0; v < masks.rows; ++v) {
    const auto* row = masks.ptr<std::uint16_t>(v);
    for (int u = 0; u < masks.cols; ++u)
      if (row[u] != 0 && (u == 0 || row[u] != row[u - 1])) ids.insert(row[u]);
  }
  return ids;
}

std::map<int, Silhouette> outlines(const cv::Mat& masks, const cv::Mat& depth, const Camera& camera,
                                   const SilhouetteOptions& options, bool segmented,
                                   std::int64_t known_at_frame) {
  auto result = silhouettes(masks, depth, camera, options);
  for (auto& [id, silhouette] : result) {
    silhouette.segmented = segmented;
    silhouette.known_at_frame = known_at_frame;
  }
  return result;
}

SurfacePoints surface_of(int id, const Camera& camera, const PointOptions& options, Work& work) {
  if (const auto found = work.surfaces.find(id); found != work.surfaces.end())
    return std::move(found->second);
  if (options.smooth_px > 0) return smoothed_points(work.depth, work.masks == id, camera, options);
  return {object_points(work.depth, work.masks == id, camera, options), {}};
}

// Without points that may be those of what the body stands on, unless most are near it: a sheet lies on a
// table.
void drop_support(const ContactPlane& plane, SurfacePoints& surface) {
  constexpr double kNoises = 2;
  std::vector<Eigen::Index> kept;
  for (Eigen::Index i = 0; i < surface.points.cols(); ++i)
    if (plane.normal.dot(surface.points.col(i)) + plane.offset_m > kNoises * plane.noise_m) kept.push_back(i);
  if (2 * std::ssize(kept) < surface.points.cols()) return;
  surface.points = Eigen::Matrix3Xd(surface.points(Eigen::all, kept));
  if (surface.normals.cols() > 0) surface.normals = Eigen::Matrix3Xd(surface.normals(Eigen::all, kept));
}

// Outlines and depth points of each body. `camera` is the lens as it is: images are not undistorted.
void look_at_bodies(const Camera& camera, const PerceptionOptions& options, std::uint64_t seed, Work& work) {
  Stopwatch watch(work.result.frame, work.times);
  if (work.masks.empty()) return;
  const std::int64_t frame = work.result.frame;
  for (auto& [id, silhouette] :
       outlines(work.masks, work.depth, camera, options.silhouettes, !options.aot.enabled, frame))
    body_of(work.result, id).silhouette = std::move(silhouette);
  for (const auto& [earlier, masks, depth] : work.arrived)
    work.late.push_back({earlier, outlines(masks, depth, camera, options.silhouettes, true, frame)});
  watch.stop("silhouettes");
  if (work.depth.empty()) return;
  for (const int id : ids_in(work.masks)) {
    BodyObservation& body = body_of(work.result, id);
    SurfacePoints surface = surface_of(id, camera, options.points, work);
    RandomStream random(seed, "contact", frame, id);
    body.contact = contact_plane(work.depth, work.masks, id, camera, options.contact, random);
    if (body.contact) drop_support(*body.contact, surface);
    body.points = std::move(surface.points);
    body.normals = std::move(surface.normals);
    if (body.normals.cols() > 0) body.colors = point_colors(work.rgb, camera, body.points);
  }
  watch.stop("points");
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

// The tracker, where the options want one.
std::unique_ptr<AsyncObjectTracker> make_tracker(const Sequence& sequence, const Segmenter& segmenter,
                                                 AotOptions options, std::uint64_t seed) {
  if (!options.enabled) return nullptr;
  options.trust_ids = options.trust_ids || segmenter.names_bodies;
  return std::make_unique<AsyncObjectTracker>(sequence.camera,
                                              slow_segmenter(sequence, segmenter, options, seed), options);
}

// That of a sequence with images, as slow as it is. It reads the images that it needs, which nothing else
// does where bodies come from scans.
std::unique_ptr<SegmenterClock> segmenter_of(const Sequence& sequence, const PerceptionOptions& options,
                                             const PerceiveOptions& run) {
  if (sequence.frames.empty()) return nullptr;
  const Segmenter segmenter = make_segmenter(sequence, options.segmentation, run.prompts);
  SlowSegmenter slow = slow_segmenter(sequence, segmenter, options.aot, run.seed);
  slow.segment = [&sequence, segmenter, seed = run.seed](const SegmenterInput& input) {
    const SequenceFrame& frame = input.frame;
    const cv::Mat depth = frame.depth.empty() ? cv::Mat() : read_depth(sequence, frame);
    return segment(segmenter, sequence, frame, depth, seed);
  };
  return make_virtual_clock(std::move(slow));
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

void warn_of_gap(const Sequence& sequence) {
  if (const auto gap = scan_gap(sequence))
    warn(fmt::format("{}: {}", (sequence.folder / "lidar.txt").string(), *gap));
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

}  // namespace

Camera perception_camera(const Sequence& sequence, const PerceptionOptions& options) {
  return sequence.frames.empty() ? scan_camera(options.scan_objects) : without_distortion(sequence.camera);
}

void perceive(const Sequence& recorded, const PerceptionOptions& options, const PerceiveOptions& run,
              PerceptionWriter& out, std::vector<StageTime>& times) {
  Sequence sequence = on_camera_clock(recorded, options.lidar_time_offset_ns);
  const bool by_lidar = options.ego == EgoSource::lidar;
  if (sequence.frames.empty() || !options.images) {
    if (!by_lidar)
      throw InputError(sequence.folder, "has no images to go by: only `ego: {source: lidar}` can follow it");
    warn_of_gap(recorded);
    const auto segmenter = options.scan_objects.masks ? segmenter_of(sequence, options, run) : nullptr;
    return perceive_scans(sequence, options.lidar, options.scan_objects, segmenter.get(), run.seed, run.quiet,
                          out, times);
  }
  const bool is_given = options.ego == EgoSource::given;
  const auto poses = is_given ? std::optional(given_poses(sequence)) : std::nullopt;
  const Segmenter segmenter = make_segmenter(sequence, options.segmentation, run.prompts);
  check_sequence(sequence, segmenter, poses, by_lidar, options.depth == DepthSource::images);
  if (options.drop_smeared_edges) sequence.depth_edge_width_px = depth_edge_width_px(sequence);
  std::optional<DepthBias> bias;
  if (options.depth_calibration && has_depth_images(sequence) && !wants_lidar_depth(sequence, options)) {
    Stopwatch watch(sequence.frames.front().frame, times);
    bias = depth_bias(sequence, options, segmenter.source == MaskSource::sequence, run);
    sequence.inverse_depth_bias_per_m = bias ? bias->per_m : 0;
    watch.stop("calibration");
  }
  const bool keeps_masks = !run.masks_folder.empty() && segmenter.source != MaskSource::sequence &&
                           segmenter.source != MaskSource::none;
  if (keeps_masks) std::filesystem::create_directories(run.masks_folder);
  FeatureTracker features(sequence.camera, options.features, run.seed, sequence.rolling_shutter_s);
  RgbdOdometry odometry(sequence.camera, options.odometry, run.seed, options.fixed_lag_s,
                        options.features.rolling_shutter.enabled ? sequence.rolling_shutter_s : 0);
  Trajectory known;  // the camera at each frame, but from features
  std::optional<LidarEgo> lidar;
  if (by_lidar) lidar.emplace(sequence, options.lidar);
  const auto tracker = make_tracker(sequence, segmenter, options.aot, run.seed);
  std::optional<LidarDepth> lidar_depth;
  const auto path = [&](std::int64_t stamp_ns) {
    return lidar ? lidar->odometry().world_from_camera(stamp_ns) : pose_between(*poses, stamp_ns);
  };
  std::optional<FramePointSource> points;
  if (wants_lidar_depth(sequence, options)) {
    points.emplace(sequence, path, frame_point_options(options.lidar_depth));
    lidar_depth.emplace(sequence, options.lidar_depth);
  }
  if (lidar || lidar_depth) warn_of_gap(recorded);
  std::deque<PerceivedFrame> waiting;  // for outlines that come late
  Progress progress("perceive", std::ssize(sequence.frames), run.quiet);

  std::size_t next = 0;
  const auto take = [&](tbb::flow_control& control) {
    auto work = std::make_shared<Work>();
    if (next == sequence.frames.size()) control.stop();
    work->index = next++;
    return work;
  };
  const auto read = [&](std::shared_ptr<Work> work) {
    const SequenceFrame& frame = sequence.frames[work->index];
    work->result.frame = frame.frame;
    work->result.stamp_ns = frame.stamp_ns;
    Stopwatch watch(frame.frame, work->times);
    work->rgb = read_rgb(sequence, frame);
    if (!frame.depth.empty()) work->depth = read_depth(sequence, frame);
    watch.stop("read");
    return work;
  };
  DepthCheck depth_check(options.depth_check);
  std::atomic<int> unusable = 0;
  const auto refuse_depth = [&](Work& work) {
    // another one: the tracker of masks keeps that which it saw
    work.depth = cv::Mat(work.depth.size(), work.depth.type(), cv::Scalar(0));
    work.surfaces.clear();
    work.result.depth_refused = true;
    ++unusable;
  };
  int images = 0, blank = 0;  // of depth
  cv::Mat last_rgb;
  Repeats repeats;
  const auto check = [&](std::shared_ptr<Work> work) {
    repeats.add(work->result.frame, is_same_image(work->rgb, last_rgb));
    last_rgb = work->rgb;
    if (work->depth.empty()) return work;
    ++images;
    if (cv::countNonZero(work->depth) == 0) {
      work->result.depth_refused = true;
      ++blank;
    } else if (!depth_check.is_measurement(work->result.stamp_ns, work->depth)) {
      refuse_depth(*work);
    }
    return work;
  };
  const auto cut_out = [&](std::shared_ptr<Work> work) {
    if (tracker) return work;
    const SequenceFrame& frame = sequence.frames[work->index];
    Stopwatch watch(frame.frame, work->times);
    work->masks = segment(segmenter, sequence, frame, work->depth, run.seed);
    watch.stop("segment");
    work->result.has_masks = !work->masks.empty();
    return work;
  };
  const auto carry = [&](std::shared_ptr<Work> work) {
    if (!tracker) return work;
    AotFrame tracked = tracker->track(sequence.frames[work->index], work->rgb, work->depth,
                                      next_stamp_ns(sequence, work->index));
    work->masks = tracked.masks;
    work->arrived = std::move(tracked.arrived);
    work->oldest_pending = tracked.oldest_pending;
    work->result.has_masks = tracked.has_masks;
    work->times.insert(work->times.end(), tracked.times.begin(), tracked.times.end());
    return work;
  };
  const auto follow = [&](std::shared_ptr<Work> work) {
    const SequenceFrame& frame = sequence.frames[work->index];
    Stopwatch watch(frame.frame, work->times);
    if (lidar) {
      lidar->track(frame, work->masks);
      watch.stop("ego");
    }
    work->world_from_camera = is_given ? pose_at(*poses, frame.stamp_ns)
                              : lidar  ? path(frame.stamp_ns)
                                       : std::nullopt;
    if (work->world_from_camera) known.push_back({frame.stamp_ns, *work->world_from_camera});
    if (points) {
      work->points = points->take(frame.stamp_ns, next_stamp_ns(sequence, work->index), work->masks);
      watch.stop("lidar_depth");
    }
    return work;
  };
  const auto look_behind = [&](std::shared_ptr<Work> work) {
    if (!lidar_depth) return work;
    Stopwatch watch(work->result.frame, work->times);
    work->depth = lidar_depth->background(work->points, work->masks);
    watch.stop("lidar_depth");
    return work;
  };
  const auto track = [&](std::shared_ptr<Work> work) {
    const SequenceFrame& frame = sequence.frames[work->index];
    Stopwatch watch(frame.frame, work->times);
    if (lidar_depth) {
      LidarView view = lidar_depth->at(work->points, work->masks, work->depth);
      work->depth = std::move(view.depth);
      work->surfaces = std::move(view.bodies);
      watch.stop("lidar_depth");
    }
    BodyHints hints;
    if (run.feedback) hints = run.feedback->hints(frame.frame, frame.stamp_ns);
    const TrackedFeatures tracked = features.track(frame, work->rgb, work->depth, work->masks, hints);
    if (tracked.depth_refused) refuse_depth(*work);
    work->result.depth_changed = tracked.depth_changed;
    add_features(tracked, work->result);
    watch.stop("features");
    if (lidar_depth) lidar_depth->saw(tracked.bodies);
    if (lidar_depth && work->points.world_from_camera && work->points.world_from_last)
      tell_motions(tracked, work->points, *lidar_depth);
    if (options.ego == EgoSource::rgbd) {
      odometry.track(frame, tracked, work->depth, work->masks);
      watch.stop("ego");
    }
    if (run.feedback)
      work->result.world_from_camera =
          options.ego == EgoSource::rgbd ? odometry.pose() : work->world_from_camera;
    return work;
  };
  const auto look = [&](std::shared_ptr<Work> work) {
    if (keeps_masks && !work->masks.empty())
      write_png(run.masks_folder / fmt::format("{:06}.png", work->result.frame), work->masks);
    look_at_bodies(sequence.camera, options, run.seed, *work);
    auto& bodies = work->result.bodies;
    std::sort(bodies.begin(), bodies.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    return work;
  };
  const auto keep = [&](const std::shared_ptr<Work>& work) {
    times.insert(times.end(), work->times.begin(), work->times.end());
    waiting.push_back(std::move(work->result));
    add_late_outlines(work->late, waiting);
    if (run.feedback) {
      Stopwatch watch(waiting.back().frame, times);
      run.feedback->take(waiting.back());
      watch.stop("feedback");
    }
    for (; !waiting.empty() && (!tracker || waiting.front().frame < work->oldest_pending);
         waiting.pop_front())
      out.add(waiting.front());
    progress.advance();
  };
  using Handle = std::shared_ptr<Work>;
  tbb::task_arena arena(threads_to_use(run.threads));
  arena.execute([&] {
    tbb::parallel_pipeline(run.feedback ? 1 : kFramesInFlight,
                           tbb::make_filter<void, Handle>(tbb::filter_mode::serial_in_order, take) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::parallel, read) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::serial_in_order, check) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::parallel, cut_out) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::serial_in_order, carry) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::serial_in_order, follow) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::parallel, look_behind) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::serial_in_order, track) &
                               tbb::make_filter<Handle, Handle>(tbb::filter_mode::parallel, look) &
                               tbb::make_filter<Handle, void>(tbb::filter_mode::serial_in_order, keep));
  });
  if (unusable > 0)
    warn(fmt::format("{} depth images are no measurements: they have one value, or jump as a whole",
                     unusable.load()));
  if (blank > 0) warn(fmt::format("{} of {} depth images hold no depth at all", blank, images));
  if (const auto runs = repeats.text())
    warn(fmt::format("frames {} have the same colour image, as of a camera that froze", *runs));
  if (segmenter.watch)
    for (const std::string& fault : segmenter.watch->faults()) warn(fault);
  if (lidar) {
    lidar->finish();
    out.keep_map(lidar->odometry().map_points());
  }
  const auto faults = lidar    ? lidar->scan_faults()
                      : points ? points->watch().faults(sequence.lidar->rate_hz)
                               : std::vector<std::string>();
  for (const std::string& fault : faults) warn(fault);
  for (const PerceivedFrame& frame : waiting) out.add(frame);
  const Trajectory later = is_given ? known : lidar ? lidar->trajectory() : Trajectory();
  out.finish(options.ego == EgoSource::rgbd
                 ? CameraTrajectories{odometry.causal_trajectory(), odometry.lagged_trajectory(),
                                      odometry.trajectory()}
                 : CameraTrajectories{known, later, later},  // a filter never goes back to a pose
             odometry.restarts(), bias, sequence.depth_edge_width_px);
}

}  // namespace uniquadric
