#include "estimator/plausibility/scan_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "estimator/ego/lidar_odometry.h"
#include "estimator/perception/ideal_ray.h"
#include "estimator/perception/scan_watch.h"
#include "estimator/plausibility/axis_turns.h"
#include "estimator/plausibility/debug.h"
#include "estimator/plausibility/turns.h"

namespace uniquadric {
namespace {

constexpr std::size_t kScans = 14;
constexpr std::size_t kPoints = 6000;  // of a scan that are put to the others
constexpr double kFarthest_m = 150, kNearest_m = 0.1;  // usual range of a LiDAR's points
constexpr double kMostRange_m = 1e9;
constexpr double kStep_s = 0.2;  // of the motions that are compared
constexpr double kLeastTurn_rad = 0.02, kSound = 0.25, kMuchBetter = 0.45;
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
  for (const std::string& fault : watch.faults(part.lidar->rate_hz)) motion.faults.push_back(list + ": " + fault);
  motion.have_times = std::ranges::count(watch.is_of_an_instant(), true) * 2 < std::ssize(part.scans);
  return all;
}

// Without the IMU, which is to be compared.
LidarOdometry odometry_of(const Sequence& part, const std::vector<std::vector<LidarPoint>>& points) {
  LidarOdometryOptions options;
  options.use_imu = false;
  options.first_sweeps = 5;
  options.first_passes = 2;
  LidarOdometry odometry({part.lidar->camera_from_lidar, {}, {}, part.lidar->noise.value_or(LidarDataSheet())},
                         {}, options);
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
    motion.pairs.push_back({a, b, drawn_points(sequence.camera, b_from_a), b_from_a});
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

std::vector<std::string> scan_turn_suspicions(const Sequence& sequence, const ScanMotion& motion) {
  if (!sequence.imu || motion.pairs.empty()) return {};
  std::vector<ImuSample> samples;
  try {
    samples = read_imu_csv(sequence.folder / "imu.csv");
  } catch (const InputError&) {
    return {};
  }
  std::vector<Turn> turns = turns_of(sequence, motion.pairs);
  std::vector<std::optional<Eigen::Vector3d>> by_imu = turns_by(samples, turns, 0);
  const Eigen::Matrix3d place = sequence.imu->camera_from_imu.rotation.toRotationMatrix(),
                        lidar = sequence.lidar->camera_from_lidar.rotation.toRotationMatrix();
  const double usual = usual_turn(turns);
  std::vector<std::string> found;
  const double scan_turn = usual / (kStep_s * sequence.lidar->rate_hz);
  if (!motion.have_times && scan_turn > kBentTurn_rad)
    found.push_back(fmt::format("{}: the points have no times within a scan, in which the sensor turns by {:.2f} rad",
                                (sequence.folder / "lidar.txt").string(), scan_turn));
  if (turns.size() < kLeastTurns || usual < kLeastTurn_rad) return found;
  // What the scans say is changed, and the gyroscope stays.
  std::vector<Turn> reference;
  std::vector<std::optional<Eigen::Vector3d>> scans;
  for (std::size_t i = 0; i < turns.size(); ++i)
    if (by_imu[i]) {
      reference.push_back({turns[i].from_ns, turns[i].to_ns, place * *by_imu[i]});
      scans.emplace_back(turns[i].vector);
    }
  const auto now = disagreement(reference, scans, [](const auto& w) { return w; });
  debug("lidar turns: {:.3f} usual {:.3f} n {}", now.value_or(-1), usual, scans.size());
  if (!now || *now < kSound) return found;
  double best = kMuchBetter * *now;
  std::string cause;
  const auto look = [&](const Eigen::Matrix3d& change, const std::string& text) {
    const auto value =
        disagreement(reference, scans, [&](const auto& w) { return Eigen::Vector3d(change * w); });
    if (value && *value < best) best = *value, cause = text;
  };
  look(lidar.transpose() * lidar.transpose(),
       "the LiDAR's place looks inverted (lidar_from_camera in place of sequence.yaml's camera_from_lidar)");
  for (const AxisTurn& axes : proper_axis_turns())
    if (!axes.matrix.isIdentity())
      look(lidar * axes.matrix * lidar.transpose(),
           fmt::format("the LiDAR turns against the IMU as if its axes were others or mirrored (x y z of turns: {})", axes.name));
  debug("   best {:.3f} {}", best, cause);
  if (cause.empty() && *now > 0.75) cause = "scans and gyroscope do not turn alike";
  if (!cause.empty())
    found.push_back(fmt::format("{}: {}: {:.0f} % of the turns off", (sequence.folder / "lidar.txt").string(), cause, 100 * *now));
  return found;
}

}  // namespace uniquadric
