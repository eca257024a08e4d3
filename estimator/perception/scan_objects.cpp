#include "estimator/perception/scan_objects.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/progress.h"
#include "core/base/quantile.h"
#include "core/base/warning.h"
#include "estimator/perception/lidar_stream.h"

namespace uniquadric {
namespace {

constexpr double kNearest = 0.5;  // [m] before the camera
constexpr std::uint16_t kNobody = 0xffff;
constexpr double kEnd = 0.3;         // [m] from a cluster's end that its last points are within
constexpr float kNearer = 2;         // [m] than a body is what may hide a part of it
constexpr float kFarOutside = 4000;  // [px]

struct ScanPoints {
  Eigen::Matrix3Xd world;           // where the sensor saw them
  std::vector<double> ago_s;        // before the scan's end
  std::vector<cv::Point2f> pixels;  // kFarOutside where the camera cannot see them
  std::vector<float> depths_m;      // z of the camera then
  std::vector<double> rises_m;      // between the sensor's rows there
};

cv::Point2f pixel_or_far(const Camera& camera, const Eigen::Vector3d& in_camera) {
  if (in_camera.z() < kNearest) return {kFarOutside, kFarOutside};
  const Eigen::Vector2d p =
      (camera.matrix() * in_camera).hnormalized().cwiseMax(-kFarOutside).cwiseMin(kFarOutside);
  return {static_cast<float>(p.x()), static_cast<float>(p.y())};
}

constexpr int kNoCluster = -1;

// The nearest of what stands on the ground, in coarse cells of the image.
class NearestDepth {
 public:
  NearestDepth(const ScanPoints& points, const std::optional<GroundPlane>& ground, double ground_m,
               const std::vector<std::vector<int>>& clusters, const Camera& camera, double cell_px)
      : cell_px_(std::max(1.0, cell_px)),
        size_(cell(camera.width) + 1, cell(camera.height) + 1),
        cells_(static_cast<std::size_t>(size_.area())) {
    std::vector<int> cluster_of(points.pixels.size(), kNoCluster);
    for (std::size_t k = 0; k < clusters.size(); ++k)
      for (const int i : clusters[k]) cluster_of[i] = static_cast<int>(k);
    for (std::size_t i = 0; i < points.pixels.size(); ++i) {
      if (ground && ground->height_of(points.world.col(static_cast<Eigen::Index>(i))) < ground_m) continue;
      const cv::Point at(cell(points.pixels[i].x), cell(points.pixels[i].y));
      if (cv::Rect({}, size_).contains(at))
        cells_[at.y * size_.width + at.x].add({points.depths_m[i], cluster_of[i]});
    }
  }
  /// In the cells around a pixel, of what is not of a cluster: its own near side hides nothing of a body that
  /// is not hidden from everywhere.
  double around(const cv::Point2f& pixel, int but) const {
    const cv::Rect part = cv::Rect(cell(pixel.x) - 1, cell(pixel.y) - 1, 3, 3) & cv::Rect({}, size_);
    float least = kFarOutside;
    for (int y = part.y; y < part.y + part.height; ++y)
      for (int x = part.x; x < part.x + part.width; ++x)
        for (const Entry& entry : cells_[y * size_.width + x].two)
          if (entry.cluster != but) least = std::min(least, entry.depth_m);
    return least;
  }

 private:
  struct Entry {
    float depth_m = kFarOutside;
    int cluster = kNoCluster;
  };
  struct Cell {
    std::array<Entry, 2> two;  // the nearest, and the nearest of another cluster
    void add(const Entry& entry) {
      if (entry.cluster == two[0].cluster)
        two[0].depth_m = std::min(two[0].depth_m, entry.depth_m);
      else if (entry.depth_m < two[0].depth_m)
        two = {entry, two[0]};
      else if (entry.depth_m < two[1].depth_m)
        two[1] = entry;
    }
  };
  int cell(double pixel) const { return static_cast<int>(std::floor(pixel / cell_px_)); }
  double cell_px_;
  cv::Size size_;
  std::vector<Cell> cells_;
};

// Where in the image the sensor looks, by what it has seen so far. Far outside the rows of a spinning one
// bend away, and their hull would be without limits above and below.
void widen(const std::vector<cv::Point2f>& pixels, const Camera& camera, std::vector<cv::Point2f>& hull) {
  std::vector<cv::Point2f> all = hull;
  std::copy_if(pixels.begin(), pixels.end(), std::back_inserter(all), [&](const cv::Point2f& p) {
    return camera.contains({p.x, p.y});
  });
  if (!all.empty()) cv::convexHull(all, hull);
}

class ScanObjects {
 public:
  ScanObjects(const ScanObjectOptions& options, const SilhouetteOptions& silhouettes, std::uint64_t seed)
      : options_(options),
        silhouettes_(silhouettes),
        seed_(seed),
        camera_(scan_camera(options)),
        tracker_(options.tracker) {}

  std::vector<BodyObservation> look(std::int64_t frame, std::int64_t stamp_ns, const Pose& world_from_camera,
                                    const ScanPoints& points) {
    widen(points.pixels, camera_, view_);
    const auto ground = find_ground(points.world, options_.clusters, seed_, frame);
    const auto clusters = clusters_above(points.world, ground, options_.clusters, points.rises_m);
    const NearestDepth nearest(points, ground, options_.clusters.ground_m, clusters, camera_,
                               options_.rim_px);
    std::vector<ClusterBox> boxes;
    for (std::size_t k = 0; k < clusters.size(); ++k)
      boxes.push_back(box_of(points, clusters, k, nearest, world_from_camera.translation));
    const std::vector<TrackedCluster> tracked = tracker_.track(stamp_ns, boxes);
    std::vector<Seen> seen;
    for (std::size_t i = 0; i < clusters.size(); ++i)
      if (auto one = seen_at_end(points, clusters[i], tracked[i], world_from_camera))
        seen.push_back(std::move(*one));
    std::vector<BodyObservation> bodies = observe(frame, seen);
    add_motions(seen, stamp_ns, world_from_camera, bodies);
    last_ = {stamp_ns, world_from_camera};
    return bodies;
  }

 private:
  struct Seen {
    TrackedCluster track;
    std::vector<ImagePoint> points;
    std::vector<cv::Point> hull;
    double depth_m = 0;
    double row_gap_px = 0;  // between the sensor's rows on it
  };

  bool at_rim(const cv::Point2f& pixel) const {
    const auto rim = static_cast<float>(options_.rim_px);
    return pixel.x < rim || pixel.y < rim || pixel.x > static_cast<float>(camera_.width) - rim ||
           pixel.y > static_cast<float>(camera_.height) - rim ||
           cv::pointPolygonTest(view_, pixel, true) < rim;
  }

  // Whether a body may go on beyond a point of it: the view ends there, or something nearer begins.
  bool is_cut(const ScanPoints& points, int i, const NearestDepth& nearest, int cluster) const {
    return at_rim(points.pixels[i]) ||
           nearest.around(points.pixels[i], cluster) < points.depths_m[i] - kNearer;
  }

  ClusterBox box_of(const ScanPoints& points, const std::vector<std::vector<int>>& clusters, std::size_t k,
                    const NearestDepth& nearest, const Eigen::Vector3d& sensor) const {
    const std::vector<int>& cluster = clusters[k];
    ClusterBox box;
    box.low = box.high = points.world.col(cluster.front());
    for (const int i : cluster) {
      box.low = box.low.cwiseMin(points.world.col(i));
      box.high = box.high.cwiseMax(points.world.col(i));
    }
    std::array<int, 4> last{}, cut{};
    std::array<double, 4> ago_s{};
    for (const int i : cluster)
      for (int side = 0; side < 4; ++side) {
        const double x = points.world(side / 2, i);
        if (side % 2 ? x < box.high[side / 2] - kEnd : x > box.low[side / 2] + kEnd) continue;
        ++last[side];
        cut[side] += is_cut(points, i, nearest, static_cast<int>(k));
        ago_s[side] += points.ago_s[i];
      }
    for (int side = 0; side < 4; ++side) {
      const int axis = side / 2;
      box.cut[side] = 2 * cut[side] > last[side];
      box.ago_s[side] = ago_s[side] / last[side];
      box.hidden[side] = side % 2 ? sensor[axis] < box.low[axis] : sensor[axis] > box.high[axis];
    }
    return box;
  }

  // A cluster as the camera would see it at the scan's end; nothing where it would not.
  std::optional<Seen> seen_at_end(const ScanPoints& points, const std::vector<int>& cluster,
                                  const TrackedCluster& track, const Pose& world_from_camera) const {
    Seen seen;
    seen.track = track;
    const Pose camera_from_world = world_from_camera.inverse();
    std::vector<cv::Point> pixels;
    std::vector<double> depths, row_gaps_px;
    for (const int i : cluster) {
      Eigen::Vector3d p = points.world.col(i);
      p.head<2>() += track.velocity_mps * points.ago_s[i];
      const Eigen::Vector3d in_camera = camera_from_world * p;
      if (in_camera.z() < kNearest) return std::nullopt;
      const Eigen::Vector2d pixel = (camera_.matrix() * in_camera).hnormalized();
      if (!camera_.contains(pixel)) return std::nullopt;
      seen.points.push_back({pixel, 1 / in_camera.z()});
      pixels.emplace_back(static_cast<int>(std::lround(pixel.x())), static_cast<int>(std::lround(pixel.y())));
      depths.push_back(in_camera.z());
      row_gaps_px.push_back(camera_.fy * points.rises_m[i] / in_camera.z());
    }
    cv::convexHull(pixels, seen.hull);
    seen.depth_m = quantile(std::move(depths), 0.5);
    seen.row_gap_px = quantile(std::move(row_gaps_px), 0.5);
    return seen;
  }

  // Clusters drawn as their hulls, near ones over far ones, in what the sensor can see.
  std::map<int, Silhouette> outlines(const std::vector<Seen>& seen) const {
    cv::Mat masks(camera_.height, camera_.width, CV_16UC1, cv::Scalar(kNobody));
    cv::Mat depth(masks.size(), CV_32FC1, cv::Scalar(kNearest));
    std::vector<cv::Point> view;
    for (const cv::Point2f& p : view_) view.emplace_back(p);
    if (view.size() >= 3) {
      cv::fillConvexPoly(masks, view, cv::Scalar(0));
      cv::fillConvexPoly(depth, view, cv::Scalar(0));
    }
    std::vector<const Seen*> order;
    for (const Seen& one : seen) order.push_back(&one);
    std::stable_sort(order.begin(), order.end(),
                     [](const Seen* a, const Seen* b) { return a->depth_m > b->depth_m; });
    for (const Seen* one : order) {
      const bool is_body = one->track.seen_as_body > 0;
      cv::fillConvexPoly(masks, one->hull,
                         cv::Scalar(is_body ? static_cast<double>(one - seen.data()) + 1 : kNobody));
      cv::fillConvexPoly(depth, one->hull, cv::Scalar(one->depth_m));
    }
    return silhouettes(masks, depth, camera_, silhouettes_);
  }

  std::vector<BodyObservation> observe(std::int64_t frame, const std::vector<Seen>& seen) const {
    auto silhouettes = outlines(seen);
    std::vector<BodyObservation> bodies;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (seen[i].track.seen_as_body == 0) continue;
      BodyObservation& body = bodies.emplace_back();
      body.id = seen[i].track.id;
      PointPlaneOptions planes = options_.planes;
      planes.one_body = true;
      planes.row_gap_px = seen[i].row_gap_px;
      SurfacePoints surface =
          surface_points(point_planes(seen[i].points, planes), camera_, options_.max_points);
      body.points = std::move(surface.points);
      body.normals = std::move(surface.normals);
      const auto found = silhouettes.find(static_cast<int>(i) + 1);
      if (found == silhouettes.end()) continue;
      found->second.segmented = true;
      found->second.known_at_frame = frame;
      body.silhouette = std::move(found->second);
    }
    return bodies;
  }

  void add_motions(const std::vector<Seen>& seen, std::int64_t stamp_ns, const Pose& world_from_camera,
                   std::vector<BodyObservation>& bodies) const {
    if (!last_) return;
    for (const Seen& one : seen)
      for (BodyObservation& body : bodies) {
        if (body.id != one.track.id || one.track.seen_as_body > options_.motion_scans) continue;
        Pose moved;
        moved.translation.head<2>() =
            one.track.velocity_mps * (1e-9 * static_cast<double>(stamp_ns - last_->stamp_ns));
        body.motion = world_from_camera.inverse() * moved * last_->pose;
      }
  }

  ScanObjectOptions options_;
  SilhouetteOptions silhouettes_;
  std::uint64_t seed_;
  Camera camera_;
  ClusterTracker tracker_;
  std::vector<cv::Point2f> view_;  // hull of all pixels so far
  std::optional<StampedPose> last_;
};

ScanPoints points_at(const std::vector<TimedPoint>& timed, std::int64_t end_ns, const LidarOdometry& path,
                     const Pose& camera_from_lidar, const Camera& camera) {
  ScanPoints points;
  std::vector<Eigen::Vector3d> world;
  std::vector<double> elevations_rad, ranges_m;
  for (const TimedPoint& p : timed) {
    const auto pose = path.world_from_camera(p.stamp_ns);
    if (!pose) continue;
    const Eigen::Vector3d in_camera = camera_from_lidar * Eigen::Vector3d(p.lidar.cast<double>());
    world.push_back(*pose * in_camera);
    points.ago_s.push_back(1e-9 * static_cast<double>(end_ns - p.stamp_ns));
    points.pixels.push_back(pixel_or_far(camera, in_camera));
    points.depths_m.push_back(static_cast<float>(in_camera.z()));
    ranges_m.push_back(p.lidar.cast<double>().norm());
    elevations_rad.push_back(elevation_rad(p.lidar));
  }
  points.rises_m = row_gaps(elevations_rad);
  for (std::size_t i = 0; i < ranges_m.size(); ++i) points.rises_m[i] *= ranges_m[i];
  points.world.resize(3, std::ssize(world));
  for (std::size_t i = 0; i < world.size(); ++i) points.world.col(static_cast<Eigen::Index>(i)) = world[i];
  return points;
}

}  // namespace

Camera scan_camera(const ScanObjectOptions& options) {
  const auto side = [&](double angle_deg) {
    return 2 * static_cast<int>(options.focal_px * std::tan(angle_deg / 2 * std::numbers::pi / 180));
  };
  Camera camera;
  camera.fx = camera.fy = options.focal_px;
  camera.width = side(options.width_deg), camera.height = side(options.height_deg);
  camera.cx = (camera.width - 1) / 2.0, camera.cy = (camera.height - 1) / 2.0;
  return camera;
}

void perceive_scans(const Sequence& sequence, const LidarEgoOptions& ego, const ScanObjectOptions& options,
                    const SilhouetteOptions& silhouettes, std::uint64_t seed, bool quiet,
                    PerceptionWriter& out, std::vector<StageTime>& times) {
  LidarEgo lidar(sequence, ego);
  lidar.finish();
  out.keep_map(lidar.odometry().map_points());
  for (const std::string& fault : lidar.scan_faults()) warn(fault);
  const std::vector<std::int64_t> stamps_ns = lidar.stamps_ns();
  LidarStream stream(sequence);
  ScanObjects objects(options, silhouettes, seed);
  const Camera camera = scan_camera(options);
  Progress progress("perceive", std::ssize(stamps_ns), quiet);
  PerceivedFrame frame;
  CameraTrajectories poses;
  for (const std::int64_t stamp_ns : stamps_ns) {
    Stopwatch watch(frame.frame, times);
    const auto timed = options.enabled ? stream.take(stamp_ns) : std::vector<TimedPoint>();
    const auto pose = lidar.odometry().world_from_camera(stamp_ns);
    frame.stamp_ns = stamp_ns;
    frame.bodies.clear();
    frame.has_masks = options.enabled && pose;
    if (frame.has_masks) {
      const ScanPoints points =
          points_at(timed, stamp_ns, lidar.odometry(), sequence.lidar->camera_from_lidar, camera);
      frame.bodies = objects.look(frame.frame, stamp_ns, *pose, points);
      std::sort(frame.bodies.begin(), frame.bodies.end(),
                [](const auto& a, const auto& b) { return a.id < b.id; });
      watch.stop("clusters");
    }
    out.add(frame);
    if (pose) poses.final.push_back({stamp_ns, *pose});
    ++frame.frame;
    progress.advance();
  }
  poses.causal = poses.fixed_lag = poses.final;  // a filter never goes back to a pose
  out.finish(poses);
}

}  // namespace uniquadric
