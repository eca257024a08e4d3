#include "estimator/ego/lidar_track.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kShareGain = 0.1;                // a sweep's, in the running mean
constexpr double kAccelerometerSigma_mps2 = 0.1;  // of its bias before it is seen at work
constexpr double kGravitySigma_mps2 = 0.5;        // across what is first taken for it

constexpr std::int64_t kHeld_ns = 120'000'000;  // without a reading: what is held tells no motion any more
// Of a reading that is only held: some m/s^2 and tenths of a radian a second off.
constexpr double kHeldForce_mps2_rthz = 3, kHeldTurnRate_radps_rthz = 0.5;

bool is_held(const std::vector<ImuSample>& samples, std::int64_t from_ns, std::int64_t to_ns) {
  const auto after = std::ranges::lower_bound(samples, to_ns, {}, &ImuSample::stamp_ns);
  const auto before = std::ranges::upper_bound(samples, from_ns, {}, &ImuSample::stamp_ns);
  return (after == samples.end() ? to_ns : after->stamp_ns) -
             (before == samples.begin() ? from_ns : std::prev(before)->stamp_ns) >
         kHeld_ns;
}

// Of the readings between two times.
InertialNoise noise_of(const LidarSetting& setting, std::int64_t from_ns, std::int64_t to_ns) {
  const LidarOdometryOptions& options = setting.options;
  if (setting.imu.empty())
    return {0, options.angular_acceleration_radps2_rthz, options.acceleration_mps2_rthz, 0};
  const ImuCalibration& imu = *setting.rig.imu;
  if (is_held(setting.imu, from_ns, to_ns))
    return {kHeldTurnRate_radps_rthz, imu.gyroscope_walk_radps2_rthz, kHeldForce_mps2_rthz,
            imu.accelerometer_walk_mps3_rthz};
  return {imu.gyroscope_noise_radps_rthz, imu.gyroscope_walk_radps2_rthz, imu.accelerometer_noise_mps2_rthz,
          imu.accelerometer_walk_mps3_rthz};
}

}  // namespace

LidarSetting lidar_setting(const LidarRigView& rig, std::vector<ImuSample> imu,
                           const LidarOdometryOptions& options) {
  LidarSetting setting{rig, std::move(imu), options, {}, {}};
  if (!options.use_imu || !rig.imu) setting.imu.clear();
  const Pose camera_from_body = setting.imu.empty() ? rig.camera_from_lidar : rig.imu->camera_from_imu;
  setting.body_from_camera = camera_from_body.inverse();
  setting.body_from_lidar = setting.body_from_camera * rig.camera_from_lidar;
  return feels_force(setting) ? setting : without_force(std::move(setting));
}

LidarSetting without_force(LidarSetting setting) {
  for (ImuSample& sample : setting.imu) sample.specific_force_mps2.setZero();
  if (!setting.rig.imu) return setting;
  setting.rig.imu->gravity_mps2 = 0;
  setting.rig.imu->accelerometer_noise_mps2_rthz = setting.options.acceleration_mps2_rthz;
  return setting;
}

bool feels_force(const LidarSetting& setting) {
  return !setting.imu.empty() && setting.rig.imu->gravity_mps2 > 0;
}

LidarTrack::LidarTrack(const LidarSetting& setting, double row_gap_rad)
    : setting_(&setting),
      row_gap_rad_(row_gap_rad),
      sight_(setting.options.sight),
      map_(setting.options.map) {}

void LidarTrack::begin_at(const LidarState& start, bool is_guess) {
  const Matrix18d known = belief_.covariance;
  const bool has_imu = !setting_->imu.empty(), has_force = feels_force(*setting_);
  const double velocity = is_guess ? setting_->options.first_velocity_mps : 0.3;
  const double turn = has_imu ? 0.02 : is_guess ? 1.0 : 0.1;
  Vector18d sigma;
  sigma << Vector3d::Constant(1e-4), Vector3d::Constant(1e-4), Vector3d::Constant(velocity),
      Vector3d::Constant(turn), Vector3d::Constant(has_force ? kAccelerometerSigma_mps2 : 0.0),
      has_force ? Vector3d(kGravitySigma_mps2, kGravitySigma_mps2, 0) : Vector3d::Zero();
  belief_ = {start, sigma.cwiseAbs2().asDiagonal()};
  for (const int part : {kVelocity, kGyroscope})
    if (!is_guess) belief_.covariance.block<3, 3>(part, part) += known.block<3, 3>(part, part);
  map_ = LidarMap(setting_->options.map);
  usual_share_ = 0;
  reports_.clear();
  fixes_.clear();
  note_fix();
}

double LidarTrack::place_sigma_m() const {
  return std::sqrt(belief_.covariance.block<3, 3>(kPlace, kPlace).trace());
}

void LidarTrack::note_fix() {
  const LidarState& state = belief_.state;
  const auto pieces = readings_between(setting_->imu, state.stamp_ns, state.stamp_ns + 1);
  const Vector3d rate = pieces.front().reading.angular_velocity_radps - state.gyroscope_bias_radps;
  fixes_.push_back({state, rate, place_sigma_m()});
}

void LidarTrack::note(const SweepReport& report) {
  note_fix();
  reports_.push_back(report);
  reports_.back().place_covariance_m2 = belief_.covariance.block<3, 3>(kPlace, kPlace);
}

void LidarTrack::go_on(const LidarSweep& sweep) {
  const LidarOdometryOptions& options = setting_->options;
  const auto pieces = readings_between(setting_->imu, belief_.state.stamp_ns, sweep.end_ns);
  const SweepPath path(belief_.state, pieces);
  for (const auto& [end_ns, reading] : pieces)
    belief_ = propagated(belief_, reading, noise_of(*setting_, belief_.state.stamp_ns, end_ns), end_ns);
  SweepReport report{sweep.end_ns, static_cast<int>(sweep.points.size()), 0, sweep.on_bodies, 0};
  if (sweep.points.empty()) return note(report);
  LidarRegistration registration(map_, sweep.points, path, setting_->body_from_lidar, options.sweep.voxel_m,
                                 belief_.covariance, point_sigmas(sight_, setting_->rig.noise), row_gap_rad_,
                                 sight_);
  const LidarBelief found = updated(
      belief_,
      [&](const LidarState& state, int iteration) {
        const LidarNormal normal = registration.normal_at(state, iteration);
        return feels_force(*setting_) ? normal : with_bent_map(normal, options.bend_mps, options.bend_radps);
      },
      options.iterations);
  const double share = registration.share_on_planes();
  const bool is_uncertain = place_sigma_m() > options.lost_sigma_m / 2;
  if (is_uncertain && share < options.found_share * usual_share_) return note(report);  // put to wrong walls
  if (share > 0) usual_share_ = usual_share_ > 0 ? usual_share_ + kShareGain * (share - usual_share_) : share;
  belief_ = feels_force(*setting_) ? with_gravity(found, setting_->rig.imu->gravity_mps2) : found;
  // Where lost, a map would be one of another place, and be taken for known soon after.
  if (map_.blocks() == 0 || place_sigma_m() <= options.lost_sigma_m)
    for (const LidarMapPoint& p : registration.map_points(belief_.state)) map_.add(p.world, p.elevation_rad);
  map_.trim(belief_.state.world_from_body.translation);
  report.on_planes = registration.on_planes();
  report.rms_m = registration.rms_m();
  note(report);
}

}  // namespace uniquadric
