#include "estimator/ego/lidar_odometry.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "estimator/ego/lidar_start.h"
#include "estimator/ego/world_frame.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr std::int64_t kMaskReach_ns = 50'000'000;  // half a frame at 10 Hz: later masks are others'
constexpr std::int64_t kBeyondEnds_ns =
    150'000'000;                   // that the motion is trusted before and after the sweeps
constexpr int kMaskMargin_px = 6;  // outlines' error, and the motion since the mask

struct Mask {
  std::int64_t stamp_ns = 0;
  cv::Mat ids;
};

// Cubic through both places and velocities, and likewise for the turn between them.
Pose between(const LidarFix& a, const LidarFix& b, std::int64_t stamp_ns) {
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

Pose beyond(const LidarFix& a, std::int64_t stamp_ns) {
  const double dt = static_cast<double>(stamp_ns - a.state.stamp_ns) * 1e-9;
  const Pose& p = a.state.world_from_body;
  return {p.rotation * exp_so3(dt * a.turn_rate_radps), p.translation + dt * a.state.velocity_mps};
}

}  // namespace

struct LidarOdometry::State {
  LidarSetting setting;
  std::deque<TimedPoint> waiting;  // in order of their stamps
  std::deque<Mask> masks;
  std::optional<std::int64_t> start_ns;  // of the first scan
  LidarStart start{setting};
  LidarTrack track{setting};  // empty until the start is known

  explicit State(LidarSetting given) : setting(std::move(given)) {}

  bool is_on_body(const TimedPoint& point) const;
  LidarSweep take_sweep(std::int64_t end_ns);
  bool has_begun() const { return !track.fixes().empty(); }
  void begin(std::optional<LidarTrack> found) {
    if (found) track = std::move(*found);
  }
  Pose level() const;
};

bool LidarOdometry::State::is_on_body(const TimedPoint& point) const {
  const Mask* nearest = nullptr;
  for (const Mask& mask : masks)
    if (!nearest || std::abs(mask.stamp_ns - point.stamp_ns) < std::abs(nearest->stamp_ns - point.stamp_ns))
      nearest = &mask;
  if (!nearest || std::abs(nearest->stamp_ns - point.stamp_ns) > kMaskReach_ns) return false;
  const auto pixel = setting.rig.camera->project(setting.rig.camera_from_lidar * point.lidar.cast<double>());
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

LidarSweep LidarOdometry::State::take_sweep(std::int64_t end_ns) {
  LidarSweep sweep{end_ns, {}, 0};
  for (; !waiting.empty() && waiting.front().stamp_ns <= end_ns; waiting.pop_front()) {
    if (is_on_body(waiting.front()))
      ++sweep.on_bodies;
    else
      sweep.points.push_back(waiting.front());
  }
  while (masks.size() > 1 && masks.front().stamp_ns < end_ns - 2 * kMaskReach_ns) masks.pop_front();
  return sweep;
}

LidarOdometry::LidarOdometry(const LidarRigView& rig, std::vector<ImuSample> imu,
                             const LidarOdometryOptions& options)
    : state_(std::make_unique<State>(lidar_setting(rig, std::move(imu), options))) {}
LidarOdometry::LidarOdometry(LidarOdometry&&) noexcept = default;
LidarOdometry::~LidarOdometry() = default;

void LidarOdometry::add_scan(std::int64_t start_ns, const std::vector<LidarPoint>& points) {
  State& s = *state_;
  const auto clean = clean_points(start_ns, points, s.setting.options.sweep);
  if (!s.start_ns) s.start.set_time(*(s.start_ns = start_ns));
  const auto middle = static_cast<std::ptrdiff_t>(s.waiting.size());
  s.waiting.insert(s.waiting.end(), clean.begin(), clean.end());
  std::inplace_merge(s.waiting.begin(), s.waiting.begin() + middle, s.waiting.end(),
                     [](const TimedPoint& a, const TimedPoint& b) { return a.stamp_ns < b.stamp_ns; });
}

void LidarOdometry::add_masks(std::int64_t stamp_ns, const cv::Mat& masks) {
  if (state_->setting.rig.camera && !masks.empty()) state_->masks.push_back({stamp_ns, masks.clone()});
}

void LidarOdometry::end_sweep(std::int64_t end_ns) {
  State& s = *state_;
  LidarSweep sweep = s.take_sweep(end_ns);
  if (!s.start_ns || end_ns <= *s.start_ns) return;
  if (s.has_begun())
    s.track.go_on(sweep);
  else
    s.begin(s.start.add(std::move(sweep)));
}

void LidarOdometry::finish() {
  if (!state_->has_begun()) state_->begin(state_->start.finish());
}

// The world that is handed out: z up, origin at the first camera.
Pose LidarOdometry::State::level() const {
  const Pose first = track.fixes().front().state.world_from_body * setting.body_from_camera;
  const Vector3d gravity = track.belief().state.gravity_mps2;
  const Vector3d up = gravity.norm() > 0 ? Vector3d(-gravity.normalized()) : Vector3d::UnitZ();
  return upright_world_from_camera(first.rotation.conjugate() * up) * first.inverse();
}

std::optional<Pose> LidarOdometry::world_from_camera(std::int64_t stamp_ns) const {
  const auto& fixes = state_->track.fixes();
  if (fixes.empty() || stamp_ns < fixes.front().state.stamp_ns - kBeyondEnds_ns ||
      stamp_ns > fixes.back().state.stamp_ns + kBeyondEnds_ns)
    return std::nullopt;
  const auto after = std::lower_bound(fixes.begin(), fixes.end(), stamp_ns,
                                      [](const LidarFix& f, std::int64_t t) { return f.state.stamp_ns < t; });
  const LidarFix& nearest = after == fixes.end() ? fixes.back() : *after;
  if (nearest.sigma_m > state_->setting.options.lost_sigma_m) return std::nullopt;
  const bool is_beyond = after == fixes.end() || after == fixes.begin();
  const Pose pose = is_beyond ? beyond(nearest, stamp_ns) : between(*std::prev(after), *after, stamp_ns);
  Pose result = state_->level() * pose * state_->setting.body_from_camera;
  result.rotation.normalize();
  return result;
}

const std::vector<SweepReport>& LidarOdometry::reports() const {
  return state_->track.reports();
}
const LidarState& LidarOdometry::state() const {
  return state_->track.belief().state;
}
std::size_t LidarOdometry::map_blocks() const {
  return state_->track.map().blocks();
}
std::vector<Vector3d> LidarOdometry::map_points() const {
  std::vector<Vector3d> points = state_->track.map().points();
  if (points.empty()) return points;
  const Pose level = state_->level();
  for (Vector3d& p : points) p = level * p;
  return points;
}

}  // namespace uniquadric
