#include "core/sequence/imu_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/quantile.h"
#include "core/base/seconds.h"
#include "core/sequence/trajectory.h"

namespace uniquadric {
namespace {

constexpr double kGap = 3.5;          // ours: times the usual, as of scans: one or two may be lost on the way
constexpr double kLeastGap_s = 0.05;  // ours: half a scan of most; shorter ones bend no sweep
constexpr double kGravityTolerance = 0.2;  // ours: relative; a sensor's own motion cancels over its readings
constexpr double kSteady_s = 1;  // ours: accelerations of hands and vehicles cancel, turns are small yet
constexpr double kMostTurn_radps = 10;  // ours: 573 deg/s, half of the time

double usual_step_s(const std::vector<ImuSample>& samples, const ImuCalibration& calibration) {
  std::vector<double> steps_s;
  for (std::size_t i = 1; i < samples.size(); ++i)
    steps_s.push_back(seconds(samples[i - 1].stamp_ns, samples[i].stamp_ns));
  return steps_s.empty() ? 1 / calibration.rate_hz : upper_median(std::move(steps_s));
}

std::optional<std::string> gap_fault(const std::vector<ImuSample>& samples, double usual_s,
                                     std::int64_t first_ns, std::int64_t last_ns) {
  struct Gap {
    std::int64_t from_ns = 0, to_ns = 0;
  } longest;
  int gaps = 0;
  const double most_s = std::max(kLeastGap_s, kGap * usual_s);
  const auto look = [&](std::int64_t from_ns, std::int64_t to_ns) {
    const Gap gap{std::max(from_ns, first_ns), std::min(to_ns, last_ns)};
    if (!(seconds(gap.from_ns, gap.to_ns) > most_s)) return;
    ++gaps;
    if (gap.to_ns - gap.from_ns > longest.to_ns - longest.from_ns) longest = gap;
  };
  look(first_ns, samples.front().stamp_ns);
  for (std::size_t i = 1; i < samples.size(); ++i) look(samples[i - 1].stamp_ns, samples[i].stamp_ns);
  look(samples.back().stamp_ns, last_ns);
  if (gaps == 0) return std::nullopt;
  std::string text = fmt::format("no reading from {} to {} s, where one comes every {:.4g} s",
                                 format_stamp(longest.from_ns), format_stamp(longest.to_ns), usual_s);
  if (gaps > 1) text += fmt::format(" (the longest of {} such gaps)", gaps);
  return text;
}

bool is_gravity(double force_mps2, double expected_mps2) {
  return std::abs(force_mps2 - expected_mps2) <= kGravityTolerance * expected_mps2;
}

// The mean over stretches of time in which vibration cancels.
double steady_force_mps2(const std::vector<ImuSample>& samples) {
  const double time_s = seconds(samples.front().stamp_ns, samples.back().stamp_ns);
  const auto stretches = std::clamp<std::size_t>(std::llround(time_s / kSteady_s), 1, samples.size());
  std::vector<double> norms_mps2;
  for (std::size_t i = 0; i < stretches; ++i) {
    const std::size_t begin = i * samples.size() / stretches, end = (i + 1) * samples.size() / stretches;
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (std::size_t at = begin; at < end; ++at) sum += samples[at].specific_force_mps2;
    norms_mps2.push_back(sum.norm() / static_cast<double>(end - begin));
  }
  return upper_median(std::move(norms_mps2));
}

std::optional<std::string> force_fault(const std::vector<ImuSample>& samples, double gravity_mps2) {
  double mean_mps2 = 0;
  for (const ImuSample& sample : samples)
    mean_mps2 += sample.specific_force_mps2.norm() / static_cast<double>(samples.size());
  const auto is_near = [&](double expected) { return is_gravity(mean_mps2, expected); };
  if (is_near(gravity_mps2) || is_gravity(steady_force_mps2(samples), gravity_mps2)) return std::nullopt;
  return fmt::format("the specific force is {:.4g} m/s^2 on average, where gravity_mps2 is {:.4g}{}",
                     mean_mps2, gravity_mps2, is_near(1) ? ": in g?" : "");
}

std::optional<std::string> turn_fault(const std::vector<ImuSample>& samples) {
  std::vector<double> turns_radps;
  for (const ImuSample& sample : samples) turns_radps.push_back(sample.angular_velocity_radps.norm());
  const double usual_radps = upper_median(std::move(turns_radps));
  if (usual_radps <= kMostTurn_radps) return std::nullopt;
  return fmt::format("the angular velocity is {:.4g} rad/s or more half of the time: in deg/s?", usual_radps);
}

}  // namespace

std::vector<std::string> imu_faults(const std::vector<ImuSample>& samples, const ImuCalibration& calibration,
                                    std::int64_t first_ns, std::int64_t last_ns) {
  std::vector<std::string> faults;
  for (const auto& fault : {gap_fault(samples, usual_step_s(samples, calibration), first_ns, last_ns),
                            force_fault(samples, calibration.gravity_mps2), turn_fault(samples)})
    if (fault) faults.push_back(*fault);
  return faults;
}

}  // namespace uniquadric
