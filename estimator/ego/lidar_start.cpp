#include "estimator/ego/lidar_start.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "core/base/quantile.h"
#include "estimator/ego/world_frame.h"
#include "estimator/shape/lidar_clusters.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kLevelTime_s = 0.2;  // whose mean force tells up from down at first
// Of the ground that tells it where there is no force; within twice the ranges' noise of a plane.
constexpr UprightOptions kGround{
    .plane_threshold_m = 0.05, .min_share = 0.1, .max_tilt_deg = 40, .max_range_m = 30};
constexpr double kUpsideDown = -0.7;  // cosine between the LiDAR's up and the camera's
constexpr double kGroundVoxel_m = 0.5;
constexpr double kWholeShare = 0.9;   // of first_sweep_s: scans come unevenly
constexpr double kBentThickness = 6;  // over the noise of points
constexpr int kMostPasses = 8;        // through the beginning, while its motion still changes
constexpr std::size_t kHeatSweeps = 2, kTrialSweeps = 5;  // that a first velocity is tried on
constexpr std::size_t kFinalists = 6;                     // of them, that are tried on more than a heat's
constexpr std::array kTrialSpeeds_mps{8.0, 16.0, 24.0};   // one is found from 4 m/s beside it
constexpr int kTrialDirections = 8;
constexpr std::size_t kFewFixes = 3;  // a beginning with fewer is too short to tell anything
constexpr double kKnown_mps = 0.03;   // standard deviation of a velocity that no other need be tried beside
constexpr double kVague_mps = 0.4;    // of one that is not told: where it is, without an IMU, 0.2 at most
constexpr double kLedBack_mps = 0.6;  // where sweeps tell the velocity, other starts end within 0.3 of it
constexpr double kAsWell = 0.95;      // of the points on planes: another start fits as well

constexpr double kLean = 0.05;          // [rad] of the mean force: less, and the motion tells no better
constexpr double kGravityOff_mps2 = 2;  // of its strength: more, and the motion that it is told by is wrong

// Gravity in the world of the fixes: what the sensor's places are bent by besides its force.
Vector3d gravity_of(const LidarTrack& track, const std::vector<ImuSample>& imu) {
  const std::vector<LidarFix>& fixes = track.fixes();
  LidarState by_force = fixes.front().state;
  by_force.velocity_mps.setZero(), by_force.gravity_mps2.setZero(),
      by_force.accelerometer_bias_mps2.setZero();
  by_force.gyroscope_bias_radps = track.belief().state.gyroscope_bias_radps;
  const auto n = static_cast<Eigen::Index>(fixes.size());
  Eigen::MatrixX3d design(n, 3), places(n, 3);
  for (Eigen::Index k = 0; k < n; ++k) {
    const LidarState& found = fixes[static_cast<std::size_t>(k)].state;
    for (const auto& [end_ns, reading] : readings_between(imu, by_force.stamp_ns, found.stamp_ns))
      by_force = propagated(by_force, reading, end_ns);
    const double t = static_cast<double>(found.stamp_ns - fixes.front().state.stamp_ns) * 1e-9;
    design.row(k) << 1, t, t * t / 2;
    places.row(k) = (found.world_from_body.translation - by_force.world_from_body.translation).transpose();
  }
  return design.colPivHouseholderQr().solve(places).row(2).transpose();
}

double points_on_planes(const LidarTrack& track) {
  double sum = 0;
  for (const SweepReport& report : track.reports()) sum += report.on_planes;
  return sum;
}

double row_gap_of(const std::vector<TimedPoint>& points) {
  std::vector<double> elevations_rad;
  for (const TimedPoint& p : points) elevations_rad.push_back(elevation_rad(p.lidar));
  return elevations_rad.empty() ? 0 : quantile(row_gaps(elevations_rad), 0.5);
}

}  // namespace

std::optional<LidarTrack> LidarStart::add(LidarSweep sweep) {
  if (sweeps_.empty() && sweep.points.empty()) return std::nullopt;  // it begins with the first points
  if (sweeps_.empty() || is_last_whole()) {
    sweeps_.push_back(std::move(sweep));
  } else {
    LidarSweep& last = sweeps_.back();
    last.end_ns = sweep.end_ns;
    last.points.insert(last.points.end(), sweep.points.begin(), sweep.points.end());
    last.on_bodies += sweep.on_bodies;
  }
  if (std::ssize(sweeps_) < setting_.options.first_sweeps || !is_last_whole()) return std::nullopt;
  auto track = finish();
  if (!track) {
    const auto half = (std::ssize(sweeps_) + 1) / 2;
    start_ns_ = sweeps_[static_cast<std::size_t>(half) - 1].end_ns;
    sweeps_.erase(sweeps_.begin(), sweeps_.begin() + half);
  }
  return track;
}

std::optional<LidarTrack> LidarStart::finish() {
  if (sweeps_.empty()) return std::nullopt;
  row_gap_rad_ = row_gap_of(sweeps_.front().points);
  const auto level = level_start();
  up_in_body_ = level ? level->up_in_body : likely_up();
  LidarTrack track = settled(level ? level->velocity_mps : likely_velocity());
  if (!has_found_start(track) || is_one_of_many(track)) return std::nullopt;
  return track;
}

// Of the beginning sweeps are whole scans however they are cut later: a spinning sensor's look one way each,
// and what two of them see in turn tells no motion.
bool LidarStart::is_last_whole() const {
  const auto last = sweeps_.size() - 1;
  const std::int64_t from_ns = last == 0 ? start_ns_ : sweeps_[last - 1].end_ns;
  return static_cast<double>(sweeps_[last].end_ns - from_ns) >=
         1e9 * kWholeShare * setting_.options.first_sweep_s;
}

// At rest a mean force points up. Without an IMU the ground tells, or else the sensor's own up.
Vector3d LidarStart::likely_up() const {
  Vector3d force = Vector3d::Zero();
  for (const ImuSample& sample : setting_.imu)
    if (std::abs(static_cast<double>(sample.stamp_ns - start_ns_)) < kLevelTime_s * 1e9)
      force += sample.specific_force_mps2;
  if (force.norm() == 0 && !setting_.imu.empty()) force = setting_.imu.front().specific_force_mps2;
  if (force.norm() > 0) return force;
  Vector3d sensors_own = setting_.body_from_lidar.rotation * Vector3d::UnitZ();
  const Vector3d cameras = -(setting_.body_from_camera.rotation * Vector3d::UnitY());
  if (cameras.dot(sensors_own) < kUpsideDown) sensors_own = -sensors_own;
  if (!setting_.imu.empty()) return sensors_own;
  const std::vector<TimedPoint>& scan = sweeps_.front().points;
  std::vector<Vector3d> points;
  for (const int i : choose_points(scan, kGroundVoxel_m).point_of)
    if (const Vector3d p = scan[static_cast<std::size_t>(i)].lidar.cast<double>();
        p.norm() < kGround.max_range_m)
      points.emplace_back(setting_.body_from_lidar * p);
  RandomStream random(0, "lidar_ground", static_cast<std::uint64_t>(start_ns_));
  return find_up(std::move(points), sensors_own, kGround, random).value_or(sensors_own);
}

// What the force tells of up from down once the motion is known, which turns and scans alone tell at first,
// as in Zhu et al., "Robust real-time LiDAR-inertial initialization", arXiv 2202.11006: its mean would take a
// vehicle's own acceleration for a tilt.
std::optional<LidarStart::LevelStart> LidarStart::level_start() const {
  if (!feels_force(setting_)) return std::nullopt;
  const LidarSetting turns = without_force(setting_);
  LidarStart start(turns);
  start.start_ns_ = start_ns_, start.sweeps_ = sweeps_;
  start.up_in_body_ = likely_up(), start.row_gap_rad_ = row_gap_rad_;
  const LidarTrack track = start.settled(start.likely_velocity());
  if (track.fixes().size() <= kFewFixes || !start.has_found_start(track)) return std::nullopt;
  const Vector3d gravity = gravity_of(track, setting_.imu);
  if (std::abs(gravity.norm() - setting_.rig.imu->gravity_mps2) > kGravityOff_mps2) return std::nullopt;
  const LidarState& first = track.fixes().front().state;
  const Eigen::Quaterniond body_from_world = first.world_from_body.rotation.conjugate();
  const Vector3d told = (body_from_world * -gravity).normalized(), mean = start.up_in_body_.normalized();
  const Vector3d up = (told - mean).norm() > kLean ? told : mean;
  const auto world_from_body = Eigen::Quaterniond::FromTwoVectors(up, Vector3d::UnitZ());
  return LevelStart{up, world_from_body * (body_from_world * first.velocity_mps)};
}

LidarState LidarStart::first_guess(const Vector3d& velocity_mps) const {
  LidarState state;
  state.stamp_ns = start_ns_;
  state.velocity_mps = velocity_mps;
  state.world_from_body = {Eigen::Quaterniond::FromTwoVectors(up_in_body_, Vector3d::UnitZ()),
                           Vector3d::Zero()};
  if (!setting_.imu.empty()) state.gravity_mps2 = {0, 0, -setting_.rig.imu->gravity_mps2};
  return state;
}

// To the start, under the readings on the way.
LidarState LidarStart::run_back(LidarState state) const {
  const auto pieces = readings_between(setting_.imu, start_ns_, state.stamp_ns);
  for (std::size_t i = pieces.size(); i-- > 0;)
    state = propagated(state, pieces[i].reading, i == 0 ? start_ns_ : pieces[i - 1].end_ns);
  return state;
}

// The state at the start by what the last pass found. The velocity is that from place to place: the filter's
// own stays near the one that the first cloud was bent by, for the next clouds are bent alike and fit.
// Gravity and the accelerometer's bias begin anew: a wrong motion would be handed on with what excuses it.
LidarState LidarStart::better_start(const LidarTrack& track) const {
  const std::vector<LidarFix>& fixes = track.fixes();
  const LidarState& last = track.belief().state;
  const std::size_t middle = std::min<std::size_t>(2, fixes.size() - 2);
  const LidarState &before = fixes[middle - 1].state, &after = fixes[middle + 1].state;
  const double dt = static_cast<double>(after.stamp_ns - before.stamp_ns) * 1e-9;
  LidarState start = fixes[middle].state;
  start.velocity_mps = (after.world_from_body.translation - before.world_from_body.translation) / dt;
  start.gyroscope_bias_radps =
      setting_.imu.empty()
          ? Vector3d(-log_so3(before.world_from_body.rotation.conjugate() * after.world_from_body.rotation) /
                     dt)
          : last.gyroscope_bias_radps;
  start.accelerometer_bias_mps2 = last.accelerometer_bias_mps2;
  start.gravity_mps2 = last.gravity_mps2;
  start = run_back(start);
  LidarState result = first_guess(Vector3d::Zero());
  const Eigen::Quaterniond turn =
      result.world_from_body.rotation * start.world_from_body.rotation.conjugate();
  result.velocity_mps = turn * start.velocity_mps;
  result.gyroscope_bias_radps = start.gyroscope_bias_radps;
  return result;
}

// Share of the first sweeps' points that lie on planes of the sweeps before, where the sensor begins at this
// velocity; 0 for another one than rest that they do not tell.
double LidarStart::share_from(const Vector3d& velocity_mps, std::size_t sweeps) const {
  LidarTrack trial(setting_, row_gap_rad_);
  trial.allow_thickness(kBentThickness);
  trial.begin_at(first_guess(velocity_mps), true);
  for (const LidarSweep& sweep : std::span(sweeps_).first(std::min(sweeps_.size(), sweeps)))
    trial.go_on(sweep);
  double points = 0;
  for (const SweepReport& report : trial.reports()) points += report.points;
  const double velocity_sigma =
      std::sqrt(trial.belief().covariance.block<3, 3>(kVelocity, kVelocity).trace());
  const bool is_told = velocity_sigma < setting_.options.first_velocity_mps / 2;
  return points > 0 && (is_told || velocity_mps.isZero()) ? points_on_planes(trial) / points : 0;
}

// What stands still beside the sensor whatever its velocity, as rings on a road do, holds it to a start at
// rest. At another velocity than the true one less fits, and where only such rings are seen, most at rest,
// where they fall on themselves.
Vector3d LidarStart::likely_velocity() const {
  std::vector<Vector3d> tried{Vector3d::Zero()};
  for (const double speed : kTrialSpeeds_mps)
    for (int k = 0; k < kTrialDirections; ++k) {
      const double angle = 2 * std::numbers::pi * k / kTrialDirections;
      tried.emplace_back(speed * std::cos(angle), speed * std::sin(angle), 0);
    }
  const auto order = [&](std::size_t sweeps) {
    std::vector<std::pair<double, std::size_t>> ranks(tried.size());
    tbb::parallel_for(std::size_t{0}, tried.size(), [&](std::size_t i) {
      ranks[i] = {-share_from(tried[i], sweeps), i};
    });
    std::sort(ranks.begin(), ranks.end());
    std::vector<Vector3d> sorted;
    for (const auto& [share, i] : ranks) sorted.push_back(tried[i]);
    return sorted;
  };
  tried = order(kHeatSweeps);
  tried.resize(kFinalists);
  return order(kTrialSweeps).front();
}

// The first cloud is bent by a motion that only the next ones tell; so the first sweeps are gone through
// again with what was found, until it changes no more.
LidarTrack LidarStart::settled(const Vector3d& velocity_mps) const {
  const LidarOdometryOptions& options = setting_.options;
  LidarTrack track(setting_, row_gap_rad_);
  track.begin_at(first_guess(velocity_mps), true);
  for (int pass = 1;; ++pass) {
    // In a cloud bent by an unknown motion walls are thick.
    track.allow_thickness(pass == 1 && pass < options.first_passes ? kBentThickness
                                                                   : options.sight.max_thickness);
    for (const LidarSweep& sweep : sweeps_) track.go_on(sweep);
    if (track.fixes().size() < kFewFixes || pass >= kMostPasses) return track;
    if (pass >= options.first_passes && has_found_start(track)) return track;
    track.begin_at(better_start(track), false);
  }
}

// The passes have come to an end: the motion that was put in is the one that came out.
bool LidarStart::has_found_start(const LidarTrack& track) const {
  if (track.fixes().size() < kFewFixes) return true;
  const LidarState found = better_start(track), used = track.fixes().front().state;
  return (found.velocity_mps - used.velocity_mps).norm() <= setting_.options.first_change_mps;
}

// Whether the sweeps hardly tell the velocity, or fit as well to a start at another one, the least known way,
// that they do not lead back from: as in a tunnel, or over a plane.
bool LidarStart::is_one_of_many(const LidarTrack& track) const {
  if (track.fixes().size() < kFewFixes) return false;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(
      track.belief().covariance.block<3, 3>(kVelocity, kVelocity));
  const double sigma_mps = std::sqrt(spread.eigenvalues()[2]);
  if (sigma_mps < kKnown_mps || sigma_mps > kVague_mps) return sigma_mps > kVague_mps;
  const Vector3d found = track.fixes().front().state.velocity_mps, aside = spread.eigenvectors().col(2);
  std::array<bool, 2> fits{};
  tbb::parallel_for(std::size_t{0}, fits.size(), [&](std::size_t i) {
    const LidarTrack other = settled(found + (i == 0 ? 1 : -1) * setting_.options.first_velocity_mps * aside);
    fits[i] = (other.fixes().front().state.velocity_mps - found).norm() > kLedBack_mps &&
              points_on_planes(other) > kAsWell * points_on_planes(track);
  });
  return fits[0] || fits[1];
}

}  // namespace uniquadric
