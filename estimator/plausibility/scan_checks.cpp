#include "estimator/plausibility/scan_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/ego/lidar_odometry.h"
#include "estimator/lidar/scan_watch.h"
#include "estimator/observation/ideal_ray.h"
#include "estimator/plausibility/axis_turns.h"
#include "estimator/plausibility/turns.h"

namespace uniquadric {
namespace {

constexpr std::size_t kScans = 14;
constexpr std::size_t kPoints = 6000;                  // of a scan that are put to the others
constexpr double kFarthest_m = 150, kNearest_m = 0.1;  // usual range of a LiDAR's points
constexpr double kMostRange_m = 1e9;
constexpr double kLeastWay_m = 0.3;  // between scans, whose planes are known to centimetres
constexpr double kStep_s = 0.2;      // of the motions that are compared
constexpr double kLeastTurn_rad = 0.02, kSound = 0.15, kLeastOff_deg = 8, kMuchBetter = 0.45, kUseless = 0.75;
constexpr std::size_t kLeastTurns = 4;
constexpr double kBentTurn_rad = 0.02;  // within a scan, that bends it

std::optional<std::string> range_fault(const std::vector<LidarPoint>& points) {
  std::vector<double> ranges_m;
  for (const LidarPoint& p : points)
    if (const double range_m = Eigen::Vector3d(p.x, p.y, p.z).norm(); range_m > 0 && std::isfinite(range_m))
      ranges_m.push_back(range_m);
  if (ranges_m.empty()) return std::nullopt;
  const double usual_m = quantile(std::move(ranges_m), 0.5);
  if (usual_m >= kNearest_m && usual_m <= kFarthest_m) return std::nullopt;
  return fmt::format("the points are {:.3g} m away (median): they look like {}", usual_m,
                     usual_m > kFarthest_m ? "millimetres or centimetres" : "kilometres");
}

// The scans alone, some in a row from the middle.
Sequence some_scans(const Sequence& sequence) {
  Sequence part = sequence;
  const std::size_t count = std::min(kScans, part.scans.size());
  const std::size_t first = (part.scans.size() - count) / 2;
  part.scans.assign(sequence.scans.begin() + static_cast<std::ptrdiff_t>(first),
                    sequence.scans.begin() + static_cast<std::ptrdiff_t>(first + count));
  part.frames.clear();
  part.imu.reset();
  return part;
}

std::vector<LidarPoint> thinned(const std::vector<LidarPoint>& points) {
  const std::size_t step = std::max<std::size_t>(1, points.size() / kPoints);
  std::vector<LidarPoint> few;
  for (std::size_t i = 0; i < points.size(); i += step) few.push_back(points[i]);
  return few;
}

// The points of the scans, thinned out.
std::vector<std::vector<LidarPoint>> watch_points(const Sequence& part, ScanMotion& motion) {
  std::vector<std::vector<LidarPoint>> all;
  ScanWatch watch(0, kMostRange_m);
  for (const SequenceScan& scan : part.scans) {
    std::vector<LidarPoint> points = read_lidar_points(part.folder / scan.file);
    if (const auto fault = range_fault(points); fault && motion.faults.empty())
      motion.faults.push_back(fmt::format("{}: {}", (part.folder / scan.file).string(), *fault));
    all.push_back(thinned(points));
    watch.look(scan, std::move(points));
  }
  const std::string list = (part.folder / "lidar.txt").string();
  for (const std::string& fault : watch.faults(part.lidar->rate_hz))
    motion.faults.push_back(list + ": " + fault);
  motion.have_times = std::ranges::count(watch.is_of_an_instant(), true) * 2 < std::ssize(part.scans);
  return all;
}

// Without the IMU, which is to be compared.
LidarOdometry odometry_of(const Sequence& part, const std::vector<std::vector<LidarPoint>>& points) {
  LidarOdometryOptions options;
  options.use_imu = false;
  options.first_sweeps = 5;
  options.first_passes = 2;
  LidarOdometry odometry(
      {part.lidar->camera_from_lidar, {}, {}, part.lidar->noise.value_or(LidarDataSheet())}, {}, options);
  const std::int64_t period_ns = std::llround(1e9 / part.lidar->rate_hz);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::int64_t start_ns = part.scans[i].stamp_ns;
    try {
      odometry.add_scan(start_ns, points[i]);
    } catch (const std::invalid_argument& error) {
      throw InputError(part.folder / part.scans[i].file, error.what());
    }
    odometry.end_sweep(start_ns + period_ns);
  }
  odometry.finish();
  return odometry;
}

// Points over the image at several depths, where the motion puts them.
std::vector<PointPair> drawn_points(const Camera& camera, const Pose& b_from_a) {
  std::vector<PointPair> points;
  for (const double depth_m : {5.0, 10.0, 20.0})
    for (const double x : {0.2, 0.5, 0.8})
      for (const double y : {0.2, 0.5, 0.8}) {
        PointPair point;
        point.raw_a = point.a = {x * camera.width, y * camera.height};
        point.depth_a_m = depth_m;
        point.is_inlier = true;
        const auto pixel = moved_pixel(point, camera, b_from_a);
        if (!pixel) continue;
        point.raw_b = point.b = *pixel;
        points.push_back(point);
      }
  return points;
}

void add_pairs(const Sequence& sequence, const LidarOdometry& odometry, ScanMotion& motion) {
  for (std::size_t a = 0; a < sequence.frames.size(); ++a) {
    const std::int64_t stamp_ns = sequence.frames[a].stamp_ns;
    std::size_t b = a + 1;
    while (b < sequence.frames.size() && seconds(stamp_ns, sequence.frames[b].stamp_ns) < kStep_s) ++b;
    if (b >= sequence.frames.size()) return;
    const auto from = odometry.world_from_camera(stamp_ns),
               to = odometry.world_from_camera(sequence.frames[b].stamp_ns);
    if (!from || !to) continue;
    const Pose b_from_a = relative_pose(*to, *from);
    motion.pairs.push_back({a, b, drawn_points(sequence.camera, b_from_a), b_from_a, 1, kLeastWay_m});
  }
}

}  // namespace

ScanMotion scan_motion(const Sequence& sequence) {
  ScanMotion motion;
  if (!sequence.lidar || sequence.scans.size() < 3) return motion;
  try {
    const Sequence part = some_scans(sequence);
    const std::vector<std::vector<LidarPoint>> points = watch_points(part, motion);
    if (!motion.faults.empty()) return motion;
    add_pairs(sequence, odometry_of(part, points), motion);
  } catch (const InputError&) {  // is told by who reads all scans
  }
  return motion;
}

namespace {

std::string file_of(const Sequence& sequence) {
  return (sequence.folder / "lidar.txt").string();
}

// Scans whose points have no times, while the gyroscope turns.
std::optional<std::string> bent_scans(const Sequence& sequence, const std::vector<ImuSample>& samples) {
  std::vector<Turn> scans;
  for (const SequenceScan& scan : sequence.scans)
    scans.push_back({scan.stamp_ns, scan.stamp_ns + std::llround(1e9 / sequence.lidar->rate_hz),
                     Eigen::Vector3d::Zero()});
  std::vector<double> angles_rad;
  for (const auto& turn : turns_by(samples, scans, 0))
    if (turn) angles_rad.push_back(turn->norm());
  if (angles_rad.empty()) return std::nullopt;
  const double usual_rad = quantile(std::move(angles_rad), 0.5);
  if (usual_rad <= kBentTurn_rad) return std::nullopt;
  return fmt::format(
      "{}: the points of a scan all have one time, and the IMU turns by {:.2f} rad within a scan",
      file_of(sequence), usual_rad);
}

// Turns by the gyroscope, and those of the scans that they are compared with; camera axes.
struct Compared {
  std::vector<Turn> imu;
  std::vector<std::optional<Eigen::Vector3d>> scans;
};

Compared compared(const Sequence& sequence, const std::vector<ImuSample>& samples,
                  const std::vector<Turn>& turns) {
  Compared both;
  const auto by_imu = turns_by(samples, turns, 0);
  for (std::size_t i = 0; i < turns.size(); ++i) {
    if (!by_imu[i]) continue;
    both.imu.push_back(
        {turns[i].from_ns, turns[i].to_ns, sequence.imu->camera_from_imu.rotation * *by_imu[i]});
    both.scans.emplace_back(turns[i].vector);
  }
  return both;
}

// What would make the scans turn as the IMU does; empty for nothing.
std::string cause_of(const Compared& both, const Eigen::Matrix3d& camera_from_lidar, double now) {
  double best = kMuchBetter * now;
  std::string cause;
  const auto look = [&](const Eigen::Matrix3d& change, const std::string& text) {
    const auto value =
        disagreement(both.imu, both.scans, [&](const auto& w) { return Eigen::Vector3d(change * w); });
    if (value && *value < best) best = *value, cause = text;
  };
  look(camera_from_lidar.transpose() * camera_from_lidar.transpose(),
       "the LiDAR's place looks inverted (lidar_from_camera in place of sequence.yaml's camera_from_lidar)");
  for (const AxisTurn& axes : proper_axis_turns())
    if (!axes.matrix.isIdentity())
      look(camera_from_lidar * axes.matrix * camera_from_lidar.transpose(),
           fmt::format(
               "the LiDAR's axes look like others or mirrored: its turns about x y z fit the IMU's as {}",
               axes.name));
  if (cause.empty()) {
    const Eigen::Matrix3d found = best_rotation(both.imu, both.scans);
    if (const double off_deg = 180 / std::numbers::pi * rotation_angle(found); off_deg > kLeastOff_deg)
      look(found, fmt::format(
                      "the LiDAR's place in sequence.yaml (camera_from_lidar) looks turned by {:.0f} degrees "
                      "against the IMU's",
                      off_deg));
  }
  if (cause.empty() && now > kUseless) cause = "the scans do not turn as the IMU does";
  return cause;
}

}  // namespace

std::vector<std::string> scan_turn_suspicions(const Sequence& sequence, const ScanMotion& motion) {
  if (!sequence.imu || !sequence.lidar) return {};
  try {
    const std::vector<ImuSample> samples = read_imu_csv(sequence.folder / "imu.csv");
    if (!motion.have_times)
      if (const auto text = bent_scans(sequence, samples)) return {*text};
    const std::vector<Turn> turns = turns_of(sequence, motion.pairs);
    if (turns.size() < kLeastTurns || usual_turn(turns) < kLeastTurn_rad) return {};
    const Compared both = compared(sequence, samples, turns);
    const auto now = disagreement(both.imu, both.scans, [](const Eigen::Vector3d& w) { return w; });
    if (!now || *now < kSound) return {};
    const std::string cause =
        cause_of(both, sequence.lidar->camera_from_lidar.rotation.toRotationMatrix(), *now);
    if (cause.empty()) return {};
    return {fmt::format("{}: {}: {:.0f} % of the turns off", file_of(sequence), cause, 100 * *now)};
  } catch (const InputError&) {  // is told by who checks the file
    return {};
  }
}

}  // namespace uniquadric
