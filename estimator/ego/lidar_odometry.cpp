#include "estimator/ego/lidar_odometry.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <numbers>
#include <span>

#include "estimator/ego/world_frame.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kMaskReach_ns = 50'000'000;  // half a frame at 10 Hz: later masks are others'
constexpr std::int64_t kBeyondEnds_ns =
    150'000'000;                      // that the motion is trusted before and after the sweeps
constexpr int kMaskMargin_px = 6;     // outlines' error, and the motion since the mask
constexpr double kLevelTime_s = 0.2;  // whose mean force tells up from down at first
constexpr double kWholeShare = 0.9;   // of first_sweep_s: scans come unevenly
constexpr double kBentThickness = 6;  // over the noise of points
constexpr double kShareGain = 0.1;    // a sweep's, in the running mean
constexpr int kMostPasses = 8;        // through the beginning, while its motion still changes
constexpr std::size_t kHeatSweeps = 2, kTrialSweeps = 5;  // that a first velocity is tried on
constexpr std::size_t kFinalists = 6;                     // of them, that are tried on more than a heat's
constexpr std::array kTrialSpeeds_mps{8.0, 16.0, 24.0};   // one is found from 4 m/s beside it
constexpr int kTrialDirections = 8;
constexpr double kKnown_mps = 0.03;   // standard deviation of a velocity that no other need be tried beside
constexpr double kVague_mps = 0.4;    // of one that is not told: where it is, without an IMU, 0.2 at most
constexpr double kLedBack_mps = 0.6;  // where sweeps tell the velocity, other starts end within 0.3 of it
constexpr double kAsWell = 0.95;      // of the points on planes: another start fits as well
constexpr double kAccelerometerSigma_mps2 = 0.1;  // of its bias before it is seen at work
constexpr double kGravitySigma_mps2 = 0.5;        // across the first force: a vehicle's own acceleration
constexpr double kMagnitudeSigma_mps2 = 0.01;     // gravity's, over the Earth's places

struct Sweep {
  std::int64_t end_ns = 0;
  std::vector<TimedPoint> points;
  int on_bodies = 0;

  void append(const Sweep& next) {
    end_ns = next.end_ns;
    points.insert(points.end(), next.points.begin(), next.points.end());
    on_bodies += next.on_bodies;
  }
};

struct Mask {
  std::int64_t stamp_ns = 0;
  cv::Mat ids;
};

struct Pause {  // what is known at a sweep's end
  LidarState state;
  Vector3d turn_rate_radps = Vector3d::Zero();
  double sigma_m = 0;
};

// Cubic through both places and velocities, and likewise for the turn between them.
Pose between(const Pause& a, const Pause& b, std::int64_t stamp_ns) {
  const double T = static_cast<double>(b.state.stamp_ns - a.state.stamp_ns) * 1e-9;
  const double u = static_cast<double>(stamp_ns - a.state.stamp_ns) /
                   static_cast<double>(b.state.stamp_ns - a.state.stamp_ns);
  const double to_b = u * u * (3 - 2 * u), from_a = u * (1 - u) * (1 - u) * T, at_b = -u * u * (1 - u) * T;
  const Pose &p = a.state.world_from_body, &q = b.state.world_from_body;
  const Vector3d turn = log_so3(p.rotation.conjugate() * q.rotation);
  return {p.rotation * exp_so3(to_b * turn + from_a * a.turn_rate_radps + at_b * b.turn_rate_radps),
          p.translation + to_b * (q.translation - p.translation) + from_a * a.state.velocity_mps +
              at_b * b.state.velocity_mps};
}

Pose beyond(const Pause& a, std::int64_t stamp_ns) {
  const double dt = static_cast<double>(stamp_ns - a.state.stamp_ns) * 1e-9;
  const Pose& p = a.state.world_from_body;
  return {p.rotation * exp_so3(dt * a.turn_rate_radps), p.translation + dt * a.state.velocity_mps};
}

}  // namespace

struct LidarOdometry::State {
  LidarRigView rig;
  std::vector<ImuSample> imu;
  LidarOdometryOptions options;
  Pose body_from_lidar, body_from_camera;
  std::deque<TimedPoint> waiting;  // in order of their stamps
  std::deque<Mask> masks;
  std::vector<Sweep> beginning;  // until there are first_sweeps of them
  bool has_begun = false;
  std::int64_t start_ns = 0;
  bool has_start = false;

  LidarSightOptions sight;  // as it is now
  LidarBelief belief;
  LidarMap map;
  double usual_share = 0;  // of the points on planes; 0: unknown
  std::vector<Pause> pauses;
  std::vector<SweepReport> reports;

  State(const LidarRigView& view, std::vector<ImuSample> samples, const LidarOdometryOptions& given)
      : rig(view), imu(std::move(samples)), options(given), sight(given.sight), map(given.map) {
    if (!options.use_imu || !rig.imu) imu.clear();
    const Pose camera_from_body = imu.empty() ? rig.camera_from_lidar : rig.imu->camera_from_imu;
    body_from_camera = camera_from_body.inverse();
    body_from_lidar = body_from_camera * rig.camera_from_lidar;
  }

  InertialNoise noise() const;
  bool is_on_body(const TimedPoint& point) const;
  Sweep take_sweep(std::int64_t end_ns);
  void begin_at(const LidarState& start, bool is_guess);
  LidarState first_guess(const Vector3d& velocity_mps) const;
  double share_from(const Vector3d& velocity_mps, std::size_t sweeps) const;
  Vector3d likely_velocity() const;
  LidarState run_back(LidarState state) const;
  LidarState better_start() const;
  bool is_last_whole() const;
  bool has_found_start() const;
  bool is_one_of_many() const;
  double points_on_planes() const;
  void wait_for_start();
  void settle(const Vector3d& velocity_mps);
  void begin();
  void go_on(const Sweep& sweep);
  void note(const SweepReport& report);
  double place_sigma_m() const { return std::sqrt(belief.covariance.block<3, 3>(kPlace, kPlace).trace()); }
  Pose level() const;
};

InertialNoise LidarOdometry::State::noise() const {
  if (imu.empty()) return {0, options.angular_acceleration_radps2_rthz, options.acceleration_mps2_rthz, 0};
  return {rig.imu->gyroscope_noise_radps_rthz, rig.imu->gyroscope_walk_radps2_rthz,
          rig.imu->accelerometer_noise_mps2_rthz, rig.imu->accelerometer_walk_mps3_rthz};
}

bool LidarOdometry::State::is_on_body(const TimedPoint& point) const {
  const Mask* nearest = nullptr;
  for (const Mask& mask : masks)
    if (!nearest || std::abs(mask.stamp_ns - point.stamp_ns) < std::abs(nearest->stamp_ns - point.stamp_ns))
      nearest = &mask;
  if (!nearest || std::abs(nearest->stamp_ns - point.stamp_ns) > kMaskReach_ns) return false;
  const auto pixel = rig.camera->project(rig.camera_from_lidar * point.lidar.cast<double>());
  if (!pixel || !(pixel->norm() < 1e6)) return false;
  const auto u = static_cast<int>(std::lround(pixel->x())), v = static_cast<int>(std::lround(pixel->y()));
  for (int k = 0; k < 9; ++k) {
    const int x = u + (k % 3 - 1) * kMaskMargin_px, y = v + (k / 3 - 1) * kMaskMargin_px;
    if (x >= 0 && y >= 0 && x < nearest->ids.cols && y < nearest->ids.rows &&
        nearest->ids.at<std::uint16_t>(y, x) != 0)
      return true;
  }
  return false;
}

Sweep LidarOdometry::State::take_sweep(std::int64_t end_ns) {
  Sweep sweep{end_ns, {}, 0};
  for (; !waiting.empty() && waiting.front().stamp_ns <= end_ns; waiting.pop_front()) {
    if (is_on_body(waiting.front()))
      ++sweep.on_bodies;
    else
      sweep.points.push_back(waiting.front());
  }
  while (masks.size() > 1 && masks.front().stamp_ns < end_ns - 2 * kMaskReach_ns) masks.pop_front();
  return sweep;
}

// At rest a mean force points up; a vehicle's own acceleration is in the error.
LidarState LidarOdometry::State::first_guess(const Vector3d& velocity_mps) const {
  LidarState state;
  state.stamp_ns = start_ns;
  state.velocity_mps = velocity_mps;
  state.world_from_body = body_from_lidar.inverse();
  if (imu.empty()) return state;
  Vector3d force = Vector3d::Zero();
  for (const ImuSample& sample : imu)
    if (std::abs(static_cast<double>(sample.stamp_ns - start_ns)) < kLevelTime_s * 1e9)
      force += sample.specific_force_mps2;
  if (force.norm() == 0) force = imu.front().specific_force_mps2;
  if (force.norm() > 0)
    state.world_from_body = {Eigen::Quaterniond::FromTwoVectors(force, Vector3d::UnitZ()), Vector3d::Zero()};
  state.gravity_mps2 = {0, 0, -rig.imu->gravity_mps2};
  return state;
}

// Of a start that an earlier pass found, velocity and turn rate are known as well as they were after it.
void LidarOdometry::State::begin_at(const LidarState& start, bool is_guess) {
  const Matrix18d known = belief.covariance;
  const bool has_imu = !imu.empty();
  const double velocity = is_guess ? options.first_velocity_mps : 0.3;
  const double turn = has_imu ? 0.02 : is_guess ? 1.0 : 0.1;
  Vector18d sigma;
  sigma << Vector3d::Constant(1e-4), Vector3d::Constant(1e-4), Vector3d::Constant(velocity),
      Vector3d::Constant(turn), Vector3d::Constant(has_imu ? kAccelerometerSigma_mps2 : 0.0),
      has_imu ? Vector3d(kGravitySigma_mps2, kGravitySigma_mps2, kMagnitudeSigma_mps2) : Vector3d::Zero();
  belief = {start, sigma.cwiseAbs2().asDiagonal()};
  for (const int part : {kVelocity, kGyroscope})
    if (!is_guess) belief.covariance.block<3, 3>(part, part) += known.block<3, 3>(part, part);
  map = LidarMap(options.map);
  usual_share = 0;
  reports.clear();
  pauses.clear();
  note({start.stamp_ns});
  reports.clear();
}

// To the start, under the readings on the way.
LidarState LidarOdometry::State::run_back(LidarState state) const {
  const auto pieces = readings_between(imu, start_ns, state.stamp_ns);
  for (std::size_t i = pieces.size(); i-- > 0;)
    state = propagated(state, pieces[i].reading, i == 0 ? start_ns : pieces[i - 1].end_ns);
  return state;
}

// The state at the start by what the last pass found. The velocity is that from place to place: the filter's
// own stays near the one that the first cloud was bent by, for the next clouds are bent alike and fit.
// Gravity and the accelerometer's bias begin anew: a wrong motion would be handed on with what excuses it.
LidarState LidarOdometry::State::better_start() const {
  const std::size_t middle = std::min<std::size_t>(2, pauses.size() - 2);
  const LidarState &before = pauses[middle - 1].state, &after = pauses[middle + 1].state;
  const double dt = static_cast<double>(after.stamp_ns - before.stamp_ns) * 1e-9;
  LidarState start = pauses[middle].state;
  start.velocity_mps = (after.world_from_body.translation - before.world_from_body.translation) / dt;
  start.gyroscope_bias_radps =
      imu.empty()
          ? Vector3d(-log_so3(before.world_from_body.rotation.conjugate() * after.world_from_body.rotation) /
                     dt)
          : belief.state.gyroscope_bias_radps;
  start.accelerometer_bias_mps2 = belief.state.accelerometer_bias_mps2;
  start.gravity_mps2 = belief.state.gravity_mps2;
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
double LidarOdometry::State::share_from(const Vector3d& velocity_mps, std::size_t sweeps) const {
  State trial(rig, imu, options);
  trial.sight.max_thickness = kBentThickness;
  trial.begin_at(first_guess(velocity_mps), true);
  double points = 0, on_planes = 0;
  for (const Sweep& sweep : std::span(beginning).first(std::min(beginning.size(), sweeps))) {
    trial.go_on(sweep);
    points += trial.reports.back().points;
    on_planes += trial.reports.back().on_planes;
  }
  const double velocity_sigma = std::sqrt(trial.belief.covariance.block<3, 3>(kVelocity, kVelocity).trace());
  const bool is_told = velocity_sigma < options.first_velocity_mps / 2;
  return points > 0 && (is_told || velocity_mps.isZero()) ? on_planes / points : 0;
}

// What stands still beside the sensor whatever its velocity, as rings on a road do, holds it to a start at
// rest. At another velocity than the true one less fits, and where only such rings are seen, most at rest,
// where they fall on themselves.
Vector3d LidarOdometry::State::likely_velocity() const {
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
void LidarOdometry::State::settle(const Vector3d& velocity_mps) {
  has_begun = true;
  begin_at(first_guess(velocity_mps), true);
  for (int pass = 1;; ++pass) {
    // In a cloud bent by an unknown motion walls are thick.
    sight.max_thickness =
        pass == 1 && pass < options.first_passes ? kBentThickness : options.sight.max_thickness;
    for (const Sweep& sweep : beginning) go_on(sweep);
    if (pauses.size() < 3 || pass >= kMostPasses) break;
    if (pass >= options.first_passes && has_found_start()) break;
    begin_at(better_start(), false);
  }
}

void LidarOdometry::State::begin() {
  settle(likely_velocity());
  if (!has_found_start() || is_one_of_many()) return wait_for_start();
  beginning.clear();
}

// Whether the sweeps hardly tell the velocity, or fit as well to a start at another one, the least known way,
// that they do not lead back from: as in a tunnel, or over a plane.
bool LidarOdometry::State::is_one_of_many() const {
  if (pauses.size() < 3) return false;  // too short to tell
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> spread(
      belief.covariance.block<3, 3>(kVelocity, kVelocity));
  const double sigma_mps = std::sqrt(spread.eigenvalues()[2]);
  if (sigma_mps < kKnown_mps || sigma_mps > kVague_mps) return sigma_mps > kVague_mps;
  const Vector3d found = pauses.front().state.velocity_mps, aside = spread.eigenvectors().col(2);
  std::array<bool, 2> fits{};
  tbb::parallel_for(std::size_t{0}, fits.size(), [&](std::size_t i) {
    State other(rig, imu, options);
    other.start_ns = start_ns;
    other.beginning = beginning;
    other.settle(found + (i == 0 ? 1 : -1) * options.first_velocity_mps * aside);
    fits[i] = (other.pauses.front().state.velocity_mps - found).norm() > kLedBack_mps &&
              other.points_on_planes() > kAsWell * points_on_planes();
  });
  return fits[0] || fits[1];
}

double LidarOdometry::State::points_on_planes() const {
  double sum = 0;
  for (const SweepReport& report : reports) sum += report.on_planes;
  return sum;
}

// Of the beginning, in which sweeps are whole scans however they are cut later: a spinning sensor's look one
// way each, and what two of them see in turn tells no motion.
bool LidarOdometry::State::is_last_whole() const {
  if (beginning.empty()) return true;
  const auto last = beginning.size() - 1;
  const std::int64_t from_ns = last == 0 ? start_ns : beginning[last - 1].end_ns;
  return static_cast<double>(beginning[last].end_ns - from_ns) >= 1e9 * kWholeShare * options.first_sweep_s;
}

// The passes have come to an end: the motion that was put in is the one that came out.
bool LidarOdometry::State::has_found_start() const {
  if (pauses.size() < 3) return true;  // too short to tell
  const LidarState found = better_start(), used = pauses.front().state;
  return (found.velocity_mps - used.velocity_mps).norm() <= options.first_change_mps;
}

// A motion that is not known makes a map that agrees with it. So there is none, nor are there poses.
void LidarOdometry::State::wait_for_start() {
  has_begun = false;
  const auto half = static_cast<std::ptrdiff_t>(beginning.size() + 1) / 2;
  start_ns = beginning[static_cast<std::size_t>(half) - 1].end_ns;
  beginning.erase(beginning.begin(), beginning.begin() + half);
  pauses.clear();
  reports.clear();
  map = LidarMap(options.map);
}

void LidarOdometry::State::note(const SweepReport& report) {
  const auto pieces = readings_between(imu, belief.state.stamp_ns, belief.state.stamp_ns + 1);
  const Vector3d rate = pieces.front().reading.angular_velocity_radps - belief.state.gyroscope_bias_radps;
  pauses.push_back({belief.state, rate, place_sigma_m()});
  reports.push_back(report);
  reports.back().place_covariance_m2 = belief.covariance.block<3, 3>(kPlace, kPlace);
}

void LidarOdometry::State::go_on(const Sweep& sweep) {
  const auto pieces = readings_between(imu, belief.state.stamp_ns, sweep.end_ns);
  const SweepPath path(belief.state, pieces);
  for (const auto& [end_ns, reading] : pieces) belief = propagated(belief, reading, noise(), end_ns);
  SweepReport report{sweep.end_ns, static_cast<int>(sweep.points.size()), 0, sweep.on_bodies, 0};
  if (sweep.points.empty()) return note(report);
  LidarRegistration registration(map, sweep.points, path, body_from_lidar, options.sweep.voxel_m,
                                 belief.covariance, point_sigmas(sight, rig.noise), sight);
  const LidarBelief found = updated(
      belief,
      [&](const LidarState& state, int iteration) { return registration.normal_at(state, iteration); },
      options.iterations);
  const double share = registration.share_on_planes();
  const bool is_uncertain = place_sigma_m() > options.lost_sigma_m / 2;
  if (is_uncertain && share < options.found_share * usual_share) return note(report);  // put to wrong walls
  if (share > 0) usual_share = usual_share > 0 ? usual_share + kShareGain * (share - usual_share) : share;
  belief = imu.empty() ? found : with_gravity(found, rig.imu->gravity_mps2, kMagnitudeSigma_mps2);
  // Where lost, a map would be one of another place, and be taken for known soon after.
  if (map.blocks() == 0 || place_sigma_m() <= options.lost_sigma_m)
    for (const Vector3d& p : registration.map_points(belief.state)) map.add(p);
  map.trim(belief.state.world_from_body.translation);
  report.on_planes = registration.on_planes();
  report.rms_m = registration.rms_m();
  note(report);
}

LidarOdometry::LidarOdometry(const LidarRigView& rig, std::vector<ImuSample> imu,
                             const LidarOdometryOptions& options)
    : state_(std::make_unique<State>(rig, std::move(imu), options)) {}
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry::~LidarOdometry() = default;

void LidarOdometry::add_scan(std::int64_t start_ns, const std::vector<LidarPoint>& points) {
  const auto clean = clean_points(start_ns, points, state_->options.sweep);
  if (!state_->has_start) state_->start_ns = start_ns, state_->has_start = true;
  auto& waiting = state_->waiting;
  const auto middle = static_cast<std::ptrdiff_t>(waiting.size());
  waiting.insert(waiting.end(), clean.begin(), clean.end());
  std::inplace_merge(waiting.begin(), waiting.begin() + middle, waiting.end(),
                     [](const TimedPoint& a, const TimedPoint& b) { return a.stamp_ns < b.stamp_ns; });
}

void LidarOdometry::add_masks(std::int64_t stamp_ns, const cv::Mat& masks) {
  if (state_->rig.camera && !masks.empty()) state_->masks.push_back({stamp_ns, masks.clone()});
}

void LidarOdometry::end_sweep(std::int64_t end_ns) {
  State& s = *state_;
  Sweep sweep = s.take_sweep(end_ns);
  if (!s.has_start || end_ns <= s.start_ns) return;
  if (s.has_begun) return s.go_on(sweep);
  if (s.beginning.empty() && sweep.points.empty()) return;  // it begins with the first points
  if (s.is_last_whole())
    s.beginning.push_back(std::move(sweep));
  else
    s.beginning.back().append(sweep);
  if (std::ssize(s.beginning) >= s.options.first_sweeps && s.is_last_whole()) s.begin();
}

void LidarOdometry::finish() {
  if (!state_->has_begun && !state_->beginning.empty()) state_->begin();
}

// The world that is handed out: z up, origin at the first camera.
Pose LidarOdometry::State::level() const {
  const Pose first = pauses.front().state.world_from_body * body_from_camera;
  const Vector3d gravity = belief.state.gravity_mps2;
  const Vector3d up = gravity.norm() > 0 ? Vector3d(-gravity.normalized()) : Vector3d::UnitZ();
  return upright_world_from_camera(first.rotation.conjugate() * up) * first.inverse();
}

std::optional<Pose> LidarOdometry::world_from_camera(std::int64_t stamp_ns) const {
  const auto& pauses = state_->pauses;
  if (pauses.empty() || stamp_ns < pauses.front().state.stamp_ns - kBeyondEnds_ns ||
      stamp_ns > pauses.back().state.stamp_ns + kBeyondEnds_ns)
    return std::nullopt;
  const auto after = std::lower_bound(pauses.begin(), pauses.end(), stamp_ns,
                                      [](const Pause& p, std::int64_t t) { return p.state.stamp_ns < t; });
  const Pause& nearest = after == pauses.end() ? pauses.back() : *after;
  if (nearest.sigma_m > state_->options.lost_sigma_m) return std::nullopt;
  const bool is_beyond = after == pauses.end() || after == pauses.begin();
  const Pose pose = is_beyond ? beyond(nearest, stamp_ns) : between(*std::prev(after), *after, stamp_ns);
  Pose result = state_->level() * pose * state_->body_from_camera;
  result.rotation.normalize();
  return result;
}

const std::vector<SweepReport>& LidarOdometry::reports() const {
  return state_->reports;
}
const LidarState& LidarOdometry::state() const {
  return state_->belief.state;
}
std::size_t LidarOdometry::map_blocks() const {
  return state_->map.blocks();
}
std::vector<Vector3d> LidarOdometry::map_points() const {
  std::vector<Vector3d> points = state_->map.points();
  for (Vector3d& p : points) p = state_->level() * p;
  return points;
}

}  // namespace uniquadric
