#include "estimator/plausibility/imu_turns.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/base/seconds.h"
#include "estimator/plausibility/axis_turns.h"

namespace uniquadric {
namespace {

constexpr double kLeastTurn_rad = 0.02;  // usual one: less is lost in the noise of images
constexpr std::size_t kLeastTurns = 4;
constexpr double kLeastOff_deg = 8;   // of the IMU's place, that is told
constexpr double kSound = 0.12;       // disagreement that anything may explain
constexpr double kMuchBetter = 0.45;  // of the disagreement as it is
constexpr double kUseless = 0.75;     // named without a cause, too
constexpr int kMostLate_ms = 300, kLateStep_ms = 10, kLeastLate_ms = 30;
constexpr double kWindow_s = 0.2;  // over which a hand's accelerations are averaged
constexpr double kLeastGravityTurn_rad = 0.25;
constexpr double kGravityStays = 0.12;  // relative scatter of gravity that a moving sensor may have
constexpr double kUpsideDown = -0.5;    // cosine of up and the image's up
constexpr double kSideways = 0.8;       // cosine of up and the image's side

struct Best {
  double disagreement = 0;
  std::string cause;
};

void look(const std::vector<Turn>& turns, const std::vector<std::optional<Eigen::Vector3d>>& others,
          const ChangeOfTurn& change, const std::string& cause, Best& best) {
  const auto value = disagreement(turns, others, change);
  if (!value || *value >= best.disagreement) return;
  best = {*value, cause};
}

void look_at_axes(const ImuCalibration& imu, const std::vector<ImuSample>& samples,
                  const std::vector<Turn>& turns, Best& best) {
  constexpr double kDegrees = std::numbers::pi / 180;
  const Eigen::Matrix3d place = imu.camera_from_imu.rotation.toRotationMatrix();
  const auto as_they_are = turns_by(samples, turns, 0), by_degrees = turns_by(samples, turns, 0, kDegrees);
  look(
      turns, as_they_are, [&](const auto& w) { return Eigen::Vector3d(place.transpose() * w); },
      "its place looks inverted (imu_from_camera in place of sequence.yaml's camera_from_imu)", best);
  for (const AxisTurn& axes : axis_turns()) {
    const ChangeOfTurn change = [&](const Eigen::Vector3d& w) {
      return Eigen::Vector3d(place * (axes.matrix * w));
    };
    const std::string text =
        axes.matrix.isIdentity() ? "" : fmt::format("the gyroscope's x y z look like {}", axes.name);
    if (!text.empty()) look(turns, as_they_are, change, text, best);
    look(turns, by_degrees, change,
         "angular velocities look like deg/s" + (text.empty() ? text : ", and " + text), best);
  }
}

// Any other place; for where no usual mistake explains it.
void look_at_place(const Eigen::Matrix3d& place, const std::vector<Turn>& turns,
                   const std::vector<std::optional<Eigen::Vector3d>>& others, Best& best) {
  const Eigen::Matrix3d found = best_rotation(turns, others);
  const double off_deg = 180 / std::numbers::pi * rotation_angle(found * place.transpose());
  if (off_deg < kLeastOff_deg) return;
  look(
      turns, others, [&](const auto& w) { return Eigen::Vector3d(found * w); },
      fmt::format("its place in sequence.yaml (camera_from_imu) looks turned by {:.0f} degrees", off_deg),
      best);
}

}  // namespace

std::optional<std::string> gyroscope_suspicion(const ImuCalibration& imu,
                                               const std::vector<ImuSample>& samples,
                                               const std::vector<Turn>& turns) {
  if (turns.size() < kLeastTurns || usual_turn(turns) < kLeastTurn_rad) return std::nullopt;
  const Eigen::Matrix3d place = imu.camera_from_imu.rotation.toRotationMatrix();
  const ChangeOfTurn as_it_is = [&](const Eigen::Vector3d& w) { return Eigen::Vector3d(place * w); };
  const auto others = turns_by(samples, turns, 0);
  const auto now = disagreement(turns, others, as_it_is);
  if (!now || *now < kSound) return std::nullopt;
  Best best{kMuchBetter * *now, ""};
  look_at_axes(imu, samples, turns, best);
  for (int late_ms = -kMostLate_ms; late_ms <= kMostLate_ms; late_ms += kLateStep_ms)
    if (std::abs(late_ms) >= kLeastLate_ms)
      look(turns, turns_by(samples, turns, late_ms * 1'000'000LL), as_it_is,
           fmt::format("its stamps look {} by {:.2f} s", late_ms > 0 ? "late" : "early",
                       1e-3 * std::abs(late_ms)),
           best);
  if (best.cause.empty()) look_at_place(place, turns, others, best);
  if (best.cause.empty()) {
    if (*now < kUseless) return std::nullopt;
    return fmt::format("the gyroscope does not turn as the camera does: they differ by {:.0f} % of the turns",
                       100 * *now);
  }
  return fmt::format("{}: {:.0f} % off the camera's turns as it is, {:.0f} % then", best.cause, 100 * *now,
                     100 * best.disagreement);
}

namespace {

// Mean force of a window, in the camera's axes at the beginning of all, but for a change of axes.
struct Force {
  Eigen::Matrix3d first_from_now;  // IMU axes
  Eigen::Vector3d imu;
};

std::vector<Force> windows_of(const std::vector<ImuSample>& samples) {
  std::vector<Force> forces;
  Eigen::Quaterniond turned = Eigen::Quaterniond::Identity();
  Force sum{Eigen::Matrix3d::Identity(), Eigen::Vector3d::Zero()};
  int count = 0;
  std::int64_t begin_ns = samples.front().stamp_ns;
  for (std::size_t i = 1; i < samples.size(); ++i) {
    turned = turned * exp_so3(seconds(samples[i - 1].stamp_ns, samples[i].stamp_ns) *
                              samples[i].angular_velocity_radps);
    turned.normalize();
    sum.imu += samples[i].specific_force_mps2;
    ++count;
    if (seconds(begin_ns, samples[i].stamp_ns) < kWindow_s) {
      if (2 * seconds(begin_ns, samples[i].stamp_ns) < kWindow_s)
        sum.first_from_now = turned.toRotationMatrix();
      continue;
    }
    sum.imu /= count;
    forces.push_back(sum);
    sum.imu.setZero();
    sum.first_from_now = turned.toRotationMatrix();
    count = 0;
    begin_ns = samples[i].stamp_ns;
  }
  return forces;
}

// Of gravity about its mean, relative.
double scatter(const std::vector<Force>& forces, const Eigen::Matrix3d& axes) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Force& force : forces) mean += force.first_from_now * (axes * force.imu);
  mean /= static_cast<double>(forces.size());
  double sum = 0;
  for (const Force& force : forces) sum += (force.first_from_now * (axes * force.imu) - mean).norm();
  return sum / (static_cast<double>(forces.size()) * mean.norm());
}

double widest_turn(const std::vector<Force>& forces) {
  double widest = 0;
  for (const Force& force : forces)
    widest =
        std::max(widest, rotation_angle(forces.front().first_from_now.transpose() * force.first_from_now));
  return widest;
}

}  // namespace

std::optional<std::string> gravity_suspicion(const ImuCalibration& imu,
                                             const std::vector<ImuSample>& samples) {
  constexpr std::size_t kLeastWindows = 4;
  if (samples.size() < 2) return std::nullopt;
  const std::vector<Force> forces = windows_of(samples);
  if (forces.size() < kLeastWindows) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();  // up, in the camera's axes
  for (const Force& force : forces)
    mean += imu.camera_from_imu.rotation * force.imu.normalized() / static_cast<double>(forces.size());
  const double up = -mean.y();
  const double now = scatter(forces, Eigen::Matrix3d::Identity());
  if (up < kUpsideDown)
    return "gravity points up in the image: the accelerometer may be negated, or the camera upside down";
  if (std::abs(mean.x()) > kSideways)
    return "gravity points sideways in the image: the accelerometer's axes may be swapped, or the camera on "
           "its side";
  if (widest_turn(forces) < kLeastGravityTurn_rad || now < kGravityStays) return std::nullopt;
  double best = kMuchBetter * now;
  std::string name;
  for (const AxisTurn& axes : axis_turns())
    if (const double value = scatter(forces, axes.matrix); value < best) best = value, name = axes.name;
  if (name.empty()) return std::nullopt;
  return fmt::format(
      "the accelerometer's x y z look like {} of the gyroscope: gravity scatters by {:.0f} % as it is, "
      "{:.0f} % then",
      name, 100 * now, 100 * best);
}

}  // namespace uniquadric
