#include "core/sequence/imu_faults.h"

#include <gtest/gtest.h>

#include <numbers>

namespace uniquadric {
namespace {

using Faults = std::vector<std::string>;

constexpr std::int64_t kStep_ns = 5'000'000, kEnd_ns = 2'000'000'000;
constexpr double kGravity_mps2 = 9.81;

ImuSample upright_at(std::int64_t stamp_ns) {
  ImuSample sample;
  sample.stamp_ns = stamp_ns;
  sample.specific_force_mps2.z() = kGravity_mps2;
  return sample;
}

// 200 readings a second over 2 s of a sensor that stands upright, turns at 0.4 rad/s and is shaken.
std::vector<ImuSample> readings() {
  std::vector<ImuSample> samples;
  for (std::int64_t t = 0; t <= kEnd_ns; t += kStep_ns) {
    samples.push_back(upright_at(t));
    samples.back().angular_velocity_radps.z() = 0.4;
    samples.back().specific_force_mps2.x() = t / kStep_ns % 2 == 0 ? 3 : -3;
  }
  return samples;
}

Faults faults_of(const std::vector<ImuSample>& samples, std::int64_t first_ns = 0,
                 std::int64_t last_ns = kEnd_ns) {
  return imu_faults(samples, ImuCalibration(), first_ns, last_ns);
}

// Without the readings between two times, themselves kept.
std::vector<ImuSample> without(std::vector<ImuSample> samples, std::int64_t from_ns, std::int64_t to_ns) {
  std::erase_if(samples, [&](const ImuSample& s) { return s.stamp_ns > from_ns && s.stamp_ns < to_ns; });
  return samples;
}

TEST(ImuFaults, NoneOfReadingsThatCoverTheTime) {
  EXPECT_EQ(faults_of(readings()), Faults());
  EXPECT_EQ(faults_of(readings(), 100, kEnd_ns + 10 * kStep_ns), Faults());  // 0.05 s are no gap
  EXPECT_EQ(faults_of(without(readings(), 700'000'000, 750'000'000)), Faults());
}

TEST(ImuFaults, ReadingsThatBeginLateEndEarlyOrHaveHoles) {
  EXPECT_EQ(faults_of(readings(), -300'000'000),
            Faults{"no reading from -0.300000000 to 0.000000000 s, where one comes every 0.005 s"});
  EXPECT_EQ(faults_of(readings(), 0, 2'500'000'000),
            Faults{"no reading from 2.000000000 to 2.500000000 s, where one comes every 0.005 s"});
  const auto holed = without(readings(), 700'000'000, 800'000'000);
  EXPECT_EQ(faults_of(holed),
            Faults{"no reading from 0.700000000 to 0.800000000 s, where one comes every 0.005 s"});
  EXPECT_EQ(
      faults_of(without(holed, 1'000'000'000, 1'200'000'000), -300'000'000),
      Faults{"no reading from -0.300000000 to 0.000000000 s, where one comes every 0.005 s (the longest of "
             "3 such gaps)"});
  EXPECT_EQ(faults_of(holed, 900'000'000), Faults());  // nothing wanted in it
  EXPECT_EQ(faults_of(holed, 760'000'000), Faults());  // 0.04 s of it
}

// One reading a tenth of a second: a lost one is no hole.
TEST(ImuFaults, AHoleIsSeveralTimesTheUsual) {
  std::vector<ImuSample> slow;
  for (std::int64_t t = 0; t <= kEnd_ns; t += 20 * kStep_ns) slow.push_back(upright_at(t));
  EXPECT_EQ(faults_of(without(slow, 700'000'000, 900'000'000)), Faults());
  EXPECT_EQ(faults_of(without(slow, 700'000'000, 1'100'000'000)).size(), 1u);
}

TEST(ImuFaults, UnitsThatAreNotOurs) {
  auto in_g = readings(), in_deg = readings(), none = readings();
  for (ImuSample& s : in_g) s.specific_force_mps2 /= kGravity_mps2;
  for (ImuSample& s : none) s.specific_force_mps2.z() = 0;
  for (ImuSample& s : in_deg) s.angular_velocity_radps *= 180 / std::numbers::pi;
  EXPECT_EQ(faults_of(in_g),
            Faults{"the specific force is 1.046 m/s^2 on average, where gravity_mps2 is 9.81: in g?"});
  EXPECT_EQ(faults_of(none), Faults{"the specific force is 3 m/s^2 on average, where gravity_mps2 is 9.81"});
  EXPECT_EQ(faults_of(in_deg),
            Faults{"the angular velocity is 22.92 rad/s or more half of the time: in deg/s?"});
}

TEST(ImuFaults, OfOneReading) {
  EXPECT_EQ(
      faults_of({upright_at(kEnd_ns / 2)}),
      Faults{"no reading from 0.000000000 to 1.000000000 s, where one comes every 0.005 s (the longest of 2 "
             "such gaps)"});
}

}  // namespace
}  // namespace uniquadric
