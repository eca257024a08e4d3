#include "estimator/ego/lidar_ego.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include "core/base/error.h"
#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/sequence/imu_faults.h"
#include "core/sequence/stamps.h"
#include "estimator/lidar/lidar_stream.h"

namespace uniquadric {
namespace {

// What biases are told by, and more than a calibrated sensor has: sound runs end with 0.02 and 0.3 at most,
// readings in other units or axes, late ones and a LiDAR turned against them with 0.04 or 0.35 and more.
constexpr double kBiasTime_s = 2, kMostBias_radps = 0.05, kMostBias_mps2 = 0.35;
constexpr double kOffMap = 0.25;  // of the usual share of points on planes: so few are of another place
constexpr int kOffMapSweeps = 5;
// What is restless: accelerations of vehicles are under 3.5 m/s^2 and 0.2 rad/s^2, of hands 6 and 2 and more.
constexpr double kRestless_mps2 = 5, kRestless_radps2 = 2;
constexpr double kRestlessStep_s = 0.09, kRestlessSpan_s = 0.5;  // over which a place's noise is little
constexpr std::ptrdiff_t kRestlessSteps = 5;
constexpr double kStill_m = 0.05, kStill_rad = 0.02;  // over a scan: no more than points' noise at 5 m

const Sequence& with_scans(const Sequence& sequence) {
  if (!sequence.lidar)
    throw InputError(sequence.folder, "has no LiDAR scans, which the variant (ego: lidar) needs");
  require_scans(sequence);
  return sequence;
}

LidarRigView rig_of(const Sequence& sequence) {
  LidarRigView rig;
  rig.camera_from_lidar = sequence.lidar->camera_from_lidar;
  rig.imu = sequence.imu;
  rig.noise = sequence.lidar->noise.value_or(LidarDataSheet());
  rig.camera = sequence.camera;  // points on masked bodies are left out
  return rig;
}

// On the sequence's clock; the faults speak of the file's own.
std::vector<ImuSample> imu_of(const Sequence& sequence, const LidarEgoOptions& options,
                              std::vector<std::string>& faults) {
  if (!sequence.imu || !options.odometry.use_imu) return {};
  const std::filesystem::path file = sequence.folder / "imu.csv";
  std::vector<ImuSample> samples = read_imu_csv(file);
  if (samples.empty())
    throw InputError(file, "holds no reading; without an IMU the variant needs ego.lidar.use_imu: false");
  const std::int64_t first_ns = sequence.scans.front().stamp_ns;
  const std::int64_t last_ns = sequence.scans.back().stamp_ns + std::llround(1e9 / sequence.lidar->rate_hz);
  const std::int64_t offset_ns = options.imu_time_offset_ns;
  for (const std::string& fault :
       imu_faults(samples, *sequence.imu, first_ns + offset_ns, last_ns + offset_ns))
    faults.push_back(fmt::format("{}: {}", file.string(), fault));
  for (ImuSample& sample : samples) sample.stamp_ns -= offset_ns;
  if (samples.front().stamp_ns > last_ns || samples.back().stamp_ns < first_ns)
    throw InputError(
        file, fmt::format("no reading meets a scan: the readings span {}..{} s, the scans {}..{} s",
                          format_stamp(samples.front().stamp_ns), format_stamp(samples.back().stamp_ns),
                          format_stamp(first_ns), format_stamp(last_ns)));
  return samples;
}

}  // namespace

LidarEgo::LidarEgo(const Sequence& sequence, const LidarEgoOptions& options)
    : sequence_(with_scans(sequence)),
      options_(options),
      odometry_(rig_of(sequence_), imu_of(sequence_, options, imu_faults_), options.odometry),
      watch_(options.odometry.sweep.min_range_m, options.odometry.sweep.max_range_m) {
  if (sequence.frames.empty()) options_.cut = SweepCut::scans;
}

// A scan lasts its nominal time, or less where the next one comes sooner, but no less than to its last point:
// points with one time for all lie at its end, and where the intervals are uneven, after the next one's
// start.
void LidarEgo::note_end(const SequenceScan& scan, const std::vector<LidarPoint>& points) {
  std::int64_t end_ns = scan.stamp_ns + std::llround(1e9 / sequence_.lidar->rate_hz);
  if (next_scan_ + 1 < sequence_.scans.size())
    end_ns = std::min(end_ns, sequence_.scans[next_scan_ + 1].stamp_ns);
  for (const LidarPoint& p : points)
    if (watch_.is_of_use(p)) end_ns = std::max<std::int64_t>(end_ns, scan.stamp_ns + p.offset_ns);
  if (!ends_ns_.empty()) end_ns = std::max(end_ns, ends_ns_.back() + 1);
  ends_ns_.push_back(end_ns);
}

void LidarEgo::take_scans(std::int64_t until_ns) {
  for (; next_scan_ < sequence_.scans.size() && sequence_.scans[next_scan_].stamp_ns <= until_ns;
       ++next_scan_) {
    const SequenceScan& scan = sequence_.scans[next_scan_];
    const std::filesystem::path path = sequence_.folder / scan.file;
    std::vector<LidarPoint> points = read_lidar_points(path);
    try {
      odometry_.add_scan(scan.stamp_ns, points);
    } catch (const std::invalid_argument& error) {
      throw InputError(path, error.what());
    }
    note_end(scan, points);
    watch_.look(scan, std::move(points));
  }
  if (options_.cut != SweepCut::scans) return;
  for (; next_end_ < next_scan_ && ends_ns_[next_end_] <= until_ns; ++next_end_)
    odometry_.end_sweep(ends_ns_[next_end_]);
}

void LidarEgo::track(const SequenceFrame& frame, const cv::Mat& masks) {
  odometry_.add_masks(frame.stamp_ns, masks);
  take_scans(frame.stamp_ns);
  if (options_.cut == SweepCut::frames) odometry_.end_sweep(frame.stamp_ns);
}

// With frames, the scan that the last one falls into still counts.
void LidarEgo::finish() {
  if (options_.cut == SweepCut::scans) {
    const auto last = sequence_.frames.empty() ? std::numeric_limits<std::int64_t>::max()
                                               : sequence_.frames.back().stamp_ns;
    take_scans(last);
    for (; next_end_ < next_scan_; ++next_end_) odometry_.end_sweep(ends_ns_[next_end_]);
  }
  odometry_.finish();
}

std::vector<std::int64_t> LidarEgo::stamps_ns() const {
  return sequence_.frames.empty() ? ends_ns_ : stamps_of(sequence_.frames);
}

Trajectory LidarEgo::trajectory() const {
  Trajectory result;
  for (const std::int64_t stamp_ns : stamps_ns())
    if (const auto pose = odometry_.world_from_camera(stamp_ns)) result.push_back({stamp_ns, *pose});
  return result;
}

std::optional<std::string> LidarEgo::bias_fault() const {
  const auto& reports = odometry_.reports();
  if (!sequence_.imu || !options_.odometry.use_imu || reports.empty() ||
      seconds(reports.front().end_ns, reports.back().end_ns) < kBiasTime_s)
    return std::nullopt;
  const double gyroscope = odometry_.state().gyroscope_bias_radps.norm();
  const double accelerometer = odometry_.state().accelerometer_bias_mps2.norm();
  if (gyroscope <= kMostBias_radps && accelerometer <= kMostBias_mps2) return std::nullopt;
  return fmt::format(
      "imu.csv and the scans agree with biases of {:.2g} rad/s and {:.2g} m/s^2 alone, more than a "
      "calibrated IMU has: its units, axes, clock or the calibration may be wrong, and poses with them",
      gyroscope, accelerometer);
}

// A motion that is lost without the filter's knowing leaves its map behind.
std::optional<std::string> LidarEgo::map_fault() const {
  std::vector<double> shares;
  for (const SweepReport& report : odometry_.reports())
    if (report.points > 0) shares.push_back(static_cast<double>(report.on_planes) / report.points);
  if (std::ssize(shares) < 2 * kOffMapSweeps) return std::nullopt;
  const double usual = quantile(shares, 0.5);
  const auto off = std::count_if(shares.begin(), shares.end(), [&](double s) { return s < kOffMap * usual; });
  if (off < kOffMapSweeps) return std::nullopt;
  return fmt::format(
      "the points of {} of {} sweeps hardly lie on what was seen before (under {:.1f} % of them, elsewhere "
      "{:.1f} %): the motion may be wrong there",
      off, shares.size(), 100 * kOffMap * usual, 100 * usual);
}

// Without an IMU a motion is constant within a sweep. A vehicle's nearly is; of one that is not, hand-swung,
// the estimate itself tells, be it right or wrong.
std::optional<std::string> LidarEgo::restless_fault() const {
  if (sequence_.imu && options_.odometry.use_imu) return std::nullopt;
  std::vector<std::pair<double, Pose>> places;
  for (const std::int64_t end_ns : ends_ns_) {
    const double time_s = seconds(ends_ns_.front(), end_ns);
    if (!places.empty() && time_s < places.back().first + kRestlessStep_s) continue;
    if (const auto pose = odometry_.world_from_camera(end_ns)) places.emplace_back(time_s, *pose);
  }
  std::vector<double> accelerations_mps2, turns_radps2;
  for (std::size_t i = 2; i < places.size(); ++i) {
    const auto& [t0, a] = places[i - 2];
    const auto& [t1, b] = places[i - 1];
    const auto& [t2, c] = places[i];
    if (t2 - t0 > kRestlessSpan_s) continue;
    const Eigen::Vector3d v = (b.translation - a.translation) / (t1 - t0),
                          w = (c.translation - b.translation) / (t2 - t1);
    accelerations_mps2.push_back((w - v).norm() / (t2 - t1));
    const Eigen::Vector3d turn = log_so3(a.rotation.conjugate() * b.rotation) / (t1 - t0),
                          next = log_so3(b.rotation.conjugate() * c.rotation) / (t2 - t1);
    turns_radps2.push_back((next - turn).norm() / (t2 - t1));
  }
  if (std::ssize(accelerations_mps2) < kRestlessSteps) return std::nullopt;
  const double acceleration_mps2 = quantile(accelerations_mps2, 0.5),
               turn_radps2 = quantile(turns_radps2, 0.5);
  if (acceleration_mps2 <= kRestless_mps2 && turn_radps2 <= kRestless_radps2) return std::nullopt;
  return fmt::format(
      "the sensor accelerates by {:.1f} m/s^2 and {:.1f} rad/s^2 (medians), and without an IMU its motion is "
      "taken for constant within a sweep: poses may be off by decimetres and more",
      acceleration_mps2, turn_radps2);
}

bool LidarEgo::is_known_to_rest(std::size_t scan) const {
  const auto from = odometry_.world_from_camera(sequence_.scans[scan].stamp_ns),
             to = odometry_.world_from_camera(ends_ns_[scan]);
  if (!from || !to) return false;
  const Pose step = relative_pose(*from, *to);
  return step.translation.norm() <= kStill_m && log_so3(step.rotation).norm() <= kStill_rad;
}

std::vector<std::string> LidarEgo::scan_faults() const {
  std::vector<std::string> faults = imu_faults_;
  for (std::string& fault : watch_.faults(sequence_.lidar->rate_hz)) faults.push_back(std::move(fault));
  const std::vector<bool>& is_of_an_instant = watch_.is_of_an_instant();
  int bent = 0;
  for (std::size_t i = 0; i < is_of_an_instant.size(); ++i)
    bent += is_of_an_instant[i] && !is_known_to_rest(i);
  if (bent > 0)
    faults.push_back(
        fmt::format("the points of {} of {} scans have no times (one each scan), and the sensor "
                    "moves or is lost: they are taken as if its motion within a scan had been undone before",
                    bent, is_of_an_instant.size()));
  for (const auto& fault : {bias_fault(), map_fault(), restless_fault()})
    if (fault) faults.push_back(*fault);
  return faults;
}

}  // namespace uniquadric
