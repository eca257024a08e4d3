#include "estimator/perception/scan_objects.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/base/warning.h"
#include "estimator/ego/lidar_sweep.h"
#include "estimator/lidar/lidar_stream.h"
#include "estimator/lidar/scan_view.h"
#include "estimator/shape/even_choice.h"

namespace uniquadric {
namespace {

constexpr double kEnd = 0.3;      // [m] from a cluster's end that its last points are within
constexpr float kNearer = 2;      // [m] than a body is what may hide a part of it
constexpr double kLocal = 5;      // times a body's extent around it, of the ground that it stands on
constexpr int kLeastGround = 20;  // points that tell where the ground is there
constexpr double kDegree = std::numbers::pi / 180;

// How many of a body's points each mask covers.
std::map<int, int> points_under(const cv::Mat& masks, const Camera& camera, const BodyObservation& body) {
  std::map<int, int> counts;
  for (const auto& p : body.points.colwise()) {
    const auto pixel = camera.project(p);
    if (!pixel || !camera.contains(*pixel)) continue;
    const cv::Point at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
    if (!cv::Rect({}, masks.size()).contains(at)) continue;
    if (const int label = masks.at<std::uint16_t>(at); label != 0) ++counts[label];
  }
  return counts;
}

std::vector<int> clusters_of_points(std::size_t count, const std::vector<std::vector<int>>& clusters) {
  std::vector<int> cluster_of(count, kNoCluster);
  for (std::size_t k = 0; k < clusters.size(); ++k)
    for (const int i : clusters[k]) cluster_of[i] = static_cast<int>(k);
  return cluster_of;
}

// Places along the ground and heights over its plane [m], of points that hardly leave it.
using GroundPoints = std::vector<std::pair<Eigen::Vector2d, double>>;

GroundPoints points_near(const GroundPlane& ground, const Eigen::Matrix3Xd& points, double ground_m) {
  GroundPoints result;
  for (const auto& p : points.colwise())
    if (const double height_m = ground.height_of(p); std::abs(height_m) < ground_m)
      result.emplace_back(p.head<2>(), height_m);
  return result;
}

class ScanObjects {
 public:
  ScanObjects(const ScanObjectOptions& options, std::uint64_t seed)
      : options_(options), seed_(seed), tracker_(options.tracker) {}

  /// All clusters, be they bodies or not: keep_bodies() tells later.
  std::vector<BodyObservation> look(std::int64_t frame, std::int64_t stamp_ns, const Pose& world_from_camera,
                                    const ScanPoints& points) {
    view_.widen(points.bearings);
    const auto ground = find_ground(points.world, options_.clusters, seed_, frame);
    const auto clusters = clusters_above(points.world, ground, options_.clusters,
                                         {points.rises_m, points.steps_m, world_from_camera.translation});
    const NearestRange nearest(points, ground, options_.clusters.ground_m,
                               clusters_of_points(points.bearings.size(), clusters),
                               options_.beside_deg * kDegree);
    std::vector<std::vector<bool>> cuts;
    std::vector<ClusterBox> boxes;
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      std::vector<bool>& cut = cuts.emplace_back();
      for (const int i : clusters[k]) cut.push_back(is_cut(points, i, nearest, static_cast<int>(k)));
      boxes.push_back(box_of(points, clusters[k], cut, world_from_camera.translation));
    }
    const std::vector<TrackedCluster> tracked = tracker_.track(stamp_ns, boxes);
    const GroundPoints near_plane =
        ground ? points_near(*ground, points.world, options_.clusters.ground_m) : GroundPoints();
    std::vector<BodyObservation> bodies;
    for (std::size_t k = 0; k < clusters.size(); ++k) {
      bodies.push_back(
          observe(points, clusters[k], cuts[k], tracked[k], ground, near_plane, stamp_ns, world_from_camera));
      if (tracked[k].seen_as_body > 0) known_.try_emplace(tracked[k].id, frame);
    }
    std::sort(bodies.begin(), bodies.end(), [](const auto& a, const auto& b) { return a.id < b.id; });
    return bodies;
  }

  /// Of each mask (a label of CV_16UC1) of the camera's image then, the cluster that most of it lies on is
  /// known at frame `now` to be a body, if it lies under that mask: what is behind the body shows a rim.
  void see_masks(const PerceivedFrame& frame, const cv::Mat& masks, const Camera& camera, std::int64_t now) {
    if (masks.empty()) return;
    struct Most {
      int points = 0, id = 0;
    };
    std::map<int, Most> by_label;
    for (const BodyObservation& body : frame.bodies)
      for (const auto& [label, points] : points_under(masks, camera, body))
        if (points > options_.mask_share * static_cast<double>(body.points.cols()) &&
            points > by_label[label].points)
          by_label[label] = {points, body.id};
    for (const auto& [label, most] : by_label)
      if (most.points > 0) known_.try_emplace(most.id, now);
  }

  /// Leaves those that are known by now to be bodies.
  void keep_bodies(PerceivedFrame& frame) const {
    std::erase_if(frame.bodies, [&](const BodyObservation& body) { return !known_.contains(body.id); });
    for (BodyObservation& body : frame.bodies)
      body.known_at_frame = std::max(frame.frame, known_.at(body.id));
  }

  /// Of the frame that was the last before the next look.
  void end_frame(std::int64_t stamp_ns, const std::optional<Pose>& world_from_camera) {
    last_.reset();
    if (world_from_camera) last_ = {stamp_ns, *world_from_camera};
  }

 private:
  double rim_rad() const { return options_.rim_deg * kDegree; }

  // Whether a body may go on beyond a point of it: the view ends there, or something nearer begins.
  bool is_cut(const ScanPoints& points, int i, const NearestRange& nearest, int cluster) const {
    return view_.is_at_rim(points.bearings[i], rim_rad()) ||
           nearest.around(points.bearings[i], cluster) < points.ranges_m[i] - kNearer;
  }

  static ClusterBox box_of(const ScanPoints& points, const std::vector<int>& cluster,
                           const std::vector<bool>& is_cut, const Eigen::Vector3d& sensor) {
    ClusterBox box;
    box.low = box.high = points.world.col(cluster.front());
    for (const int i : cluster) {
      box.low = box.low.cwiseMin(points.world.col(i));
      box.high = box.high.cwiseMax(points.world.col(i));
    }
    std::array<int, 4> last{}, cut{};
    std::array<double, 4> ago_s{};
    for (std::size_t k = 0; k < cluster.size(); ++k)
      for (int side = 0; side < 4; ++side) {
        const double x = points.world(side / 2, cluster[k]);
        if (side % 2 ? x < box.high[side / 2] - kEnd : x > box.low[side / 2] + kEnd) continue;
        ++last[side];
        cut[side] += is_cut[k];
        ago_s[side] += points.ago_s[cluster[k]];
      }
    for (int side = 0; side < 4; ++side) {
      const int axis = side / 2;
      box.cut[side] = 2 * cut[side] > last[side];
      box.ago_s[side] = ago_s[side] / last[side];
      box.hidden[side] = side % 2 ? sensor[axis] < box.low[axis] : sensor[axis] > box.high[axis];
    }
    return box;
  }

  // A cluster as it is at the scan's end.
  BodyObservation observe(const ScanPoints& points, const std::vector<int>& cluster,
                          const std::vector<bool>& cut, const TrackedCluster& track,
                          const std::optional<GroundPlane>& ground, const GroundPoints& near_plane,
                          std::int64_t stamp_ns, const Pose& world_from_camera) const {
    BodyObservation body;
    body.id = track.id;
    const Pose camera_from_world = world_from_camera.inverse();
    const auto chosen = even_choice(std::ssize(cluster), options_.max_points);
    body.points.resize(3, std::ssize(chosen));
    Eigen::Index next = 0;
    for (const auto k : chosen) {
      const int i = cluster[static_cast<std::size_t>(k)];
      Eigen::Vector3d p = points.world.col(i);
      p.head<2>() += track.velocity_mps * points.ago_s[i];
      body.points.col(next++) = camera_from_world * p;
      body.cut.push_back(cut[static_cast<std::size_t>(k)]);
    }
    std::vector<double> rises_m, steps_m;
    for (const int i : cluster) {
      rises_m.push_back(points.rises_m[i]);
      steps_m.push_back(points.steps_m[i]);
    }
    body.row_gap_m = upper_median(std::move(rises_m));
    body.beam_gap_m = upper_median(std::move(steps_m));
    if (ground)
      body.contact = ground_under(points.world(Eigen::seqN(0, 2), cluster), *ground, near_plane,
                                  options_.clusters.ground_m / 2, camera_from_world);
    if (last_) {
      Pose moved;
      moved.translation.head<2>() = track.velocity_mps * seconds(last_->stamp_ns, stamp_ns);
      body.motion = camera_from_world * moved * last_->pose;
    }
    return body;
  }

  // A street is no plane: about a body the ground is where most of what is seen of it is.
  static ContactPlane ground_under(const Eigen::Matrix2Xd& seen, const GroundPlane& ground,
                                   const GroundPoints& near_plane, double usual_noise_m,
                                   const Pose& camera_from_world) {
    const Eigen::Vector2d middle = seen.rowwise().mean();
    const double reach_m = kLocal * (seen.rowwise().maxCoeff() - seen.rowwise().minCoeff()).norm();
    std::vector<double> heights_m;
    for (const auto& [at, height_m] : near_plane)
      if ((at - middle).norm() < reach_m) heights_m.push_back(height_m);
    const bool is_seen = std::ssize(heights_m) >= kLeastGround;
    const double raised_m = is_seen ? upper_median(heights_m) : 0;
    for (double& height_m : heights_m) height_m = std::abs(height_m - raised_m);
    const Eigen::Vector3d up(-ground.slope.x(), -ground.slope.y(), 1);
    ContactPlane plane;
    plane.noise_m = is_seen ? kMadToSigma * upper_median(heights_m) : usual_noise_m;
    const Eigen::Vector3d normal = up.normalized();
    plane.normal = camera_from_world.rotation * normal;
    const double offset_m = -(ground.offset_m + raised_m) / up.norm();
    plane.offset_m = offset_m - plane.normal.dot(camera_from_world.translation);
    return plane;
  }

  ScanObjectOptions options_;
  std::uint64_t seed_;
  ClusterTracker tracker_;
  SensorView view_;
  std::map<int, std::int64_t> known_;  // by id: the frame in which it was seen to be a body
  std::optional<StampedPose> last_;
};

ScanPoints points_at(const std::vector<TimedPoint>& timed, std::int64_t end_ns, const LidarOdometry& path,
                     const Pose& camera_from_lidar) {
  ScanPoints points;
  std::vector<Eigen::Vector3d> world;
  std::vector<double> elevations_rad;
  for (const TimedPoint& p : timed) {
    const auto pose = path.world_from_camera(p.stamp_ns);
    if (!pose) continue;
    world.push_back(*pose * (camera_from_lidar * Eigen::Vector3d(p.lidar.cast<double>())));
    points.ago_s.push_back(seconds(p.stamp_ns, end_ns));
    points.ranges_m.push_back(p.lidar.norm());
    elevations_rad.push_back(elevation_rad(p.lidar));
    points.bearings.emplace_back(std::atan2(p.lidar.y(), p.lidar.x()),
                                 static_cast<float>(elevations_rad.back()));
  }
  points.rises_m = row_gaps(elevations_rad);
  std::vector<double> azimuths_rad;
  for (const Bearing& bearing : points.bearings) azimuths_rad.push_back(bearing.x);
  const double step_rad = beam_step(azimuths_rad, elevations_rad);
  for (std::size_t i = 0; i < world.size(); ++i) {
    points.rises_m[i] *= points.ranges_m[i];
    points.steps_m.push_back(step_rad * points.ranges_m[i]);
  }
  points.world.resize(3, std::ssize(world));
  for (std::size_t i = 0; i < world.size(); ++i) points.world.col(static_cast<Eigen::Index>(i)) = world[i];
  return points;
}

// The points of the last whole scan at a time. Frames come when they want: some of them before there is a new
// one, and others after several.
class SweepBuffer {
 public:
  explicit SweepBuffer(const Sequence& sequence)
      : stream_(sequence), period_ns_(std::llround(1e9 / sequence.lidar->rate_hz)) {}

  /// Nothing while less than a scan, to within a part of it, is new.
  std::optional<std::vector<TimedPoint>> take(std::int64_t until_ns) {
    for (TimedPoint& p : stream_.take(until_ns)) points_.push_back(p);
    if (last_ns_ && until_ns - *last_ns_ < kNearlyOne * static_cast<double>(period_ns_)) return std::nullopt;
    last_ns_ = until_ns;
    std::erase_if(points_, [&](const TimedPoint& p) { return p.stamp_ns <= until_ns - period_ns_; });
    return std::exchange(points_, {});
  }

 private:
  static constexpr double kNearlyOne = 0.9;
  LidarStream stream_;
  std::int64_t period_ns_;
  std::optional<std::int64_t> last_ns_;
  std::vector<TimedPoint> points_;
};

// The last frame up to one in which a scan ended; null where it is gone.
const PerceivedFrame* look_at(const std::deque<PerceivedFrame>& frames, std::int64_t frame) {
  for (auto f = frames.rbegin(); f != frames.rend(); ++f)
    if (f->frame <= frame && f->has_masks) return &*f;
  return nullptr;
}

}  // namespace

Camera scan_camera(const ScanObjectOptions& options) {
  const auto side = [&](double angle_deg) {
    return 2 * static_cast<int>(options.focal_px * std::tan(angle_deg / 2 * kDegree));
  };
  Camera camera;
  camera.fx = camera.fy = options.focal_px;
  camera.width = side(options.width_deg), camera.height = side(options.height_deg);
  camera.cx = (camera.width - 1) / 2.0, camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

void perceive_scans(const Sequence& sequence, const LidarEgoOptions& ego, const ScanObjectOptions& options,
                    SegmenterClock* segmenter, std::uint64_t seed, bool quiet, PerceptionWriter& out,
                    std::vector<StageTime>& times) {
  LidarEgo lidar(sequence, ego);
  for (const SequenceFrame& frame : sequence.frames) lidar.track(frame, {});
  lidar.finish();
  out.keep_map(lidar.odometry().map_points());
  for (const std::string& fault : lidar.scan_faults()) warn(fault);
  const std::vector<std::int64_t> stamps_ns = lidar.stamps_ns();
  SweepBuffer sweeps(sequence);
  ScanObjects objects(options, seed);
  Progress progress("perceive", std::ssize(stamps_ns), quiet);
  PerceivedFrame frame;
  std::deque<PerceivedFrame> waiting;
  const auto write_until = [&](std::int64_t until_ns) {
    for (; !waiting.empty() && waiting.front().stamp_ns <= until_ns; waiting.pop_front()) {
      objects.keep_bodies(waiting.front());
      out.add(waiting.front());
    }
  };
  CameraTrajectories poses;
  for (std::size_t i = 0; i < stamps_ns.size(); ++i) {
    const std::int64_t stamp_ns = stamps_ns[i];
    frame.frame = sequence.frames.empty() ? static_cast<std::int64_t>(i) : sequence.frames[i].frame;
    Stopwatch watch(frame.frame, times);
    const auto timed = options.enabled ? sweeps.take(stamp_ns) : std::nullopt;
    const auto pose = lidar.odometry().world_from_camera(stamp_ns);
    frame.stamp_ns = stamp_ns;
    frame.bodies.clear();
    frame.has_masks = timed && pose;
    if (frame.has_masks) {
      const ScanPoints points =
          points_at(*timed, stamp_ns, lidar.odometry(), sequence.lidar->camera_from_lidar);
      frame.bodies = objects.look(frame.frame, stamp_ns, *pose, points);
      watch.stop("clusters");
    }
    objects.end_frame(stamp_ns, pose);
    waiting.push_back(frame);
    if (segmenter) {
      for (const SegmenterResult& result : segmenter->step({sequence.frames[i], {}, {}, {}}, stamp_ns))
        if (const PerceivedFrame* seen = look_at(waiting, result.frame))
          objects.see_masks(*seen, result.masks, sequence.camera, frame.frame);
    }
    write_until(stamp_ns - nanoseconds(options.look_back_s));
    if (pose) poses.final.push_back({stamp_ns, *pose});
    progress.advance();
  }
  if (!stamps_ns.empty()) write_until(stamps_ns.back());
  poses.causal = poses.fixed_lag = poses.final;  // a filter never goes back to a pose
  out.finish(poses);
}

}  // namespace uniquadric
