#include "tests/ego/lidar_room.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "core/base/random.h"

namespace uniquadric {
namespace {

using Eigen::Vector3d;

constexpr double kGravity_mps2 = 9.81;
constexpr double kTwoPi = 6.283185307179586;

// Unit directions of a scan: rings about z as of a spinning LiDAR, or a rosette about x as of a Livox.
Vector3d direction(LidarRoom::Pattern pattern, double u, std::int64_t shot) {
  if (pattern != LidarRoom::Pattern::forward) {
    const double azimuth = kTwoPi * u;
    const double elevation = kTwoPi / 360 *
                             (pattern == LidarRoom::Pattern::rings ? 2 * static_cast<double>(shot % 16) - 15
                                                                   : 2 * static_cast<double>(shot % 32) - 31);
    return {std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
            std::sin(elevation)};
  }
  const double angle = kTwoPi * 0.618034 * static_cast<double>(shot);
  const double off = 0.6 * std::sqrt(std::fmod(0.7548776662 * static_cast<double>(shot), 1.0));
  return {std::cos(off), std::sin(off) * std::cos(angle), std::sin(off) * std::sin(angle)};
}

struct Box {
  Vector3d low, high;
};
const std::array<Box, 6> kCupboards = {{{{5.5, -4, -2.5}, {7, -2.5, 0.5}},
                                        {{6, 0.5, -2.5}, {7, 2, -0.5}},
                                        {{5.8, 3, -1}, {7, 4, 1}},
                                        {{-7, -1, -2.5}, {-5.5, 1, 1}},
                                        {{-2, 4, -2.5}, {0, 5, 0}},
                                        {{1, -5, -2.5}, {2.5, -4, 1.5}}}};

// Half a metre deep, from floor to ceiling, as facades have them between windows, at uneven steps: at even
// ones a motion by a step more a scan would look the same.
std::vector<Box> piers(const Vector3d& half) {
  std::vector<Box> boxes;
  double x = -half.x();
  for (int k = 0; x + 1.5 < half.x(); x += 2.2 + 1.7 * std::fmod(0.618034 * ++k, 1.0))
    for (const double side : {-1.0, 1.0}) {
      const double y = side * (half.y() - 0.25);
      boxes.push_back({{x, y - 0.25, -half.z()}, {x + 1.5, y + 0.25, half.z()}});
    }
  return boxes;
}

// To where a ray from outside enters a box; nothing: it passes by.
std::optional<double> range_to(const Box& box, const Vector3d& from, const Vector3d& ray) {
  const Eigen::Array3d a = (box.low - from).array() / ray.array(),
                       b = (box.high - from).array() / ray.array();
  const double enters = a.min(b).maxCoeff(), leaves = a.max(b).minCoeff();
  return enters > 0 && enters < leaves ? std::optional(enters) : std::nullopt;
}

double off_box_m(const Box& box, const Vector3d& p) {
  const Eigen::Array3d off = (box.low - p).array().max((p - box.high).array());
  return off.maxCoeff() > 0 ? off.max(0).matrix().norm() : -off.maxCoeff();
}

}  // namespace

Pose LidarRoom::world_from_lidar(double t) const {
  const double v = vigour;
  return {exp_so3(0.3 * v *
                  Vector3d(0.3 * std::sin(1.7 * t), 0.4 * std::sin(1.3 * t + 0.5), 1.5 * std::sin(0.9 * t))) *
              exp_so3({0, tilt_rad, 0}),
          v * Vector3d(1.2 * std::sin(0.8 * t), 0.7 * std::sin(1.1 * t + 1), 0.2 * std::sin(1.9 * t)) +
              t * velocity_mps + t * t / 2 * acceleration_mps2};
}

std::int64_t LidarRoom::scan_start_ns(int scan) const {
  return start_ns + std::llround(1e9 * scan / rate_hz);
}

std::vector<LidarPoint> LidarRoom::scan(int scan) const {
  RandomStream random(7, "lidar_room", static_cast<std::uint64_t>(scan));
  std::vector<Box> boxes;
  if (has_piers)
    boxes = piers(half_size_m);
  else if (!is_bare)
    boxes.assign(kCupboards.begin(), kCupboards.end());
  std::vector<LidarPoint> result;
  for (int i = 0; i < points; ++i) {
    const double u = static_cast<double>(i) / points;
    LidarPoint point;
    point.offset_ns = static_cast<std::uint32_t>(1e9 * u / rate_hz);
    const double time_s = 1e-9 * static_cast<double>(scan_start_ns(scan) - start_ns + point.offset_ns);
    const Pose pose = world_from_lidar(time_s);
    const Vector3d beam = direction(pattern, u, i + std::int64_t{points} * scan);
    const Vector3d ray = pose.rotation * beam;
    double range = std::numeric_limits<double>::max();
    for (int k = 0; k < 3; ++k)
      range = std::min(
          range, (half_size_m[k] - std::copysign(1.0, ray[k]) * pose.translation[k]) / std::abs(ray[k]));
    for (const Box& box : boxes)
      range = std::min(range, range_to(box, pose.translation, ray).value_or(range));
    if (const Vector3d at = mover_m(time_s); mover_half_m.x() > 0)
      range = std::min(
          range, range_to({at - mover_half_m, at + mover_half_m}, pose.translation, ray).value_or(range));
    if (range > max_range_m) range = 0;
    const Eigen::Vector3f p = ((range + range_sigma_m * random.normal()) * beam).cast<float>();
    point.x = p.x(), point.y = p.y(), point.z = p.z();
    result.push_back(point);
  }
  return result;
}

std::vector<ImuSample> LidarRoom::imu(double duration_s, double rate) const {
  constexpr double kStep_s = 1e-4;  // differences err by 1e-8
  std::vector<ImuSample> samples;
  for (int i = 0; i <= std::ceil(duration_s * rate); ++i) {
    const double t = i / rate;
    const Pose before = world_from_lidar(t - kStep_s), now = world_from_lidar(t),
               after = world_from_lidar(t + kStep_s);
    const Vector3d acceleration =
        (before.translation - 2 * now.translation + after.translation) / (kStep_s * kStep_s);
    ImuSample sample;
    sample.stamp_ns = start_ns + std::llround(1e9 * t);
    sample.angular_velocity_radps =
        log_so3(before.rotation.conjugate() * after.rotation) / (2 * kStep_s) + gyroscope_bias_radps;
    sample.specific_force_mps2 =
        now.rotation.conjugate() * (acceleration + kGravity_mps2 * Vector3d::UnitZ()) +
        accelerometer_bias_mps2;
    samples.push_back(sample);
  }
  return samples;
}

double LidarRoom::off_surfaces_m(const Vector3d& p) const {
  double off = (p.cwiseAbs() - half_size_m).cwiseAbs().minCoeff();
  for (const Box& box : kCupboards) off = std::min(off, off_box_m(box, p));
  return off;
}

}  // namespace uniquadric
