#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/random.h"
#include "estimator/upright/street_sizes.h"
#include "estimator/upright/upright_filter.h"
#include "estimator/upright/upright_sight.h"

namespace uniquadric {
namespace {
using Eigen::Vector2d;

struct Box {
  Vector2d middle{0, 0};
  double yaw_rad = 0, length_m = 4.4, width_m = 1.8;
};

// Points of the sides that a sensor sees, `per_m` of them, with noise. `lengthwise`: sides along the box,
// too.
UprightSight sight_of(const Box& box, const Vector2d& sensor, double per_m, double sigma_m,
                      RandomStream& random, bool lengthwise = true) {
  const Vector2d ahead(std::cos(box.yaw_rad), std::sin(box.yaw_rad)), left(-ahead.y(), ahead.x());
  const Vector2d from = sensor - box.middle;
  std::vector<Vector2d> points;
  const auto add_side = [&](const Vector2d& normal, double off_m, const Vector2d& along, double length_m) {
    if (normal.dot(from) <= off_m) return;
    const int count = std::max(4, static_cast<int>(per_m * length_m));
    for (int i = 0; i <= count; ++i)
      points.push_back(box.middle + off_m * normal +
                       (static_cast<double>(i) / count - 0.5) * length_m * along +
                       sigma_m * Vector2d(random.normal(), random.normal()));
  };
  add_side(ahead, box.length_m / 2, left, box.width_m);
  add_side(-ahead, box.length_m / 2, left, box.width_m);
  if (lengthwise) {
    add_side(left, box.width_m / 2, ahead, box.length_m);
    add_side(-left, box.width_m / 2, ahead, box.length_m);
  }
  UprightSight sight;
  sight.sensor = sensor;
  sight.points.resize(2, std::ssize(points));
  for (std::size_t i = 0; i < points.size(); ++i) sight.points.col(static_cast<Eigen::Index>(i)) = points[i];
  sight.cut.assign(points.size(), false);
  sight.height_m = 1.5;
  sight.height_sigma_m = 0.05;
  return sight;
}

TEST(UprightSight, EndsAreThoseOfTheBox) {
  RandomStream random(1, "test");
  const Box box{{12, 7}, 0.1};
  const auto ends = box_ends(sight_of(box, {0, 0}, 40, 0, random), box.yaw_rad);
  const std::array<double, 4> half_m{2.2, 2.2, 0.9, 0.9};
  for (int side = 0; side < 4; ++side) {
    const double middle = ends[side].direction.dot(box.middle);
    EXPECT_NEAR(ends[side].position_m, middle + half_m[side], 1e-9) << side;
    EXPECT_FALSE(ends[side].is_bound) << side;
  }
}

TEST(UprightSight, WhatNoSideLeadsToIsNoEnd) {
  RandomStream random(1, "test");
  const auto ends = box_ends(sight_of({{20, 0.2}}, {0, 0}, 40, 0.01, random), 0);
  EXPECT_FALSE(ends[0].is_bound);  // its rear
  EXPECT_TRUE(ends[1].is_bound);
  EXPECT_FALSE(ends[2].is_bound);
  EXPECT_FALSE(ends[3].is_bound);
  UprightSight hidden = sight_of({{12, 5}}, {0, 0}, 40, 0, random);
  for (Eigen::Index i = 0; i < hidden.points.cols(); ++i)
    hidden.cut[static_cast<std::size_t>(i)] = hidden.points(0, i) > 13;
  EXPECT_TRUE(box_ends(hidden, 0)[1].is_bound);
  EXPECT_FALSE(box_ends(hidden, 0)[0].is_bound);
}

TEST(UprightSight, SidesInViewTellTheYaw) {
  RandomStream random(2, "test");
  for (const double yaw_rad : {-0.2, 0.0, 0.15, 0.3}) {
    const UprightSight sight = sight_of({{12, 6}, yaw_rad}, {0, 0}, 20, 0.02, random);
    const auto yaw = seen_yaw(sight, 0.1, 0.35);
    ASSERT_TRUE(yaw) << yaw_rad;
    EXPECT_NEAR(yaw->yaw_rad, yaw_rad, 0.02) << yaw_rad;
    EXPECT_LT(yaw->sigma_rad, 0.1);
  }
  EXPECT_FALSE(seen_yaw(sight_of({{12, 6}, 0.6}, {0, 0}, 20, 0.02, random), 0, 0.35));  // beyond its reach
}

// As a rear of 1.8 x 1.5 m at 10 m/s shows no length.
TEST(StreetSizes, WhatIsHiddenIsThatOfTheUserThatFits) {
  SeenSize seen;
  seen.size_m = {0.2, 1.7, 1.5};
  seen.sigma_m = {0.1, 0.1, 0.1};
  seen.is_whole = {false, true, true};
  seen.speed_mps = 10;
  const SizeBelief car = street_size(seen);
  EXPECT_NEAR(car.size_m.x(), 3.9, 0.4);
  EXPECT_GT(car.sigma_m.x(), 0.4);
  seen.size_m = {0.4, 0.5, 1.7};
  seen.speed_mps = 1.3;
  const SizeBelief walker = street_size(seen);
  EXPECT_LT(walker.size_m.x(), 1.1);
  EXPECT_LT(walker.size_m.y(), 0.8);
  seen.size_m = {9, 2.5, 3.2};
  seen.is_whole = {false, true, true};
  seen.speed_mps = 8;
  EXPECT_GT(street_size(seen).size_m.x(), 9.5);
}

// A car that turns with 0.15 rad/s before a sensor at rest: first its rear alone, then its side.
struct TurningCar {
  Box at(double t) const {
    const double w = 0.15, v = 8;
    Box box;
    box.yaw_rad = w * t;
    box.middle = Vector2d(10, 0.5) + v / w * Vector2d(std::sin(w * t), 1 - std::cos(w * t));
    return box;
  }
  UprightSight sight(int scan, RandomStream& random) const {
    UprightSight sight = sight_of(at(0.1 * scan), {0, 0}, 12, 0.02, random);
    sight.frame = scan;
    sight.stamp_ns = 100'000'000 * std::int64_t{scan};
    return sight;
  }
};

UprightFilter filter_of(const TurningCar& car, const UprightBoxOptions& options, int scans, int first = 0) {
  RandomStream random(3, "test");
  UprightFilter filter(options);
  for (int i = first; i < scans; ++i) {
    const UprightSight sight = car.sight(i, random);
    if (i == first)
      filter.start(sight, {7.5, 0.5});
    else
      filter.step(sight.frame, sight.stamp_ns, &sight);
  }
  return filter;
}

double off_m(const UprightState& state, const Box& box) {
  return (state.mean.head<2>() - box.middle).norm();
}

TEST(UprightFilter, FollowsACarThatTurnsAndFindsItsSize) {
  const TurningCar car;
  constexpr int kScans = 40;
  for (const bool street_sizes : {true, false}) {
    UprightBoxOptions options;
    options.street_sizes = street_sizes;
    const auto states = filter_of(car, options, kScans).causal();
    const UprightState& last = states.back();
    const Box truth = car.at(0.1 * (kScans - 1));
    EXPECT_LT(off_m(last, truth), 0.1) << street_sizes;
    EXPECT_NEAR(last.mean[kYaw], truth.yaw_rad, 0.03);
    EXPECT_NEAR(last.mean[kSpeed], 8, 0.3);
    EXPECT_NEAR(last.mean[kYawRate], 0.15, 0.05);
    EXPECT_NEAR(last.mean[kLength], 4.4, 0.2);
    EXPECT_NEAR(last.mean[kWidth], 1.8, 0.1);
    EXPECT_NEAR(last.mean[kHeight], 1.5, 0.1);
  }
}

// Rows 0.9 m apart: the uppermost one on a car of 1.5 m is 0.65 m up, scan after scan.
TEST(UprightFilter, RowsThatAreFarApartDoNotMakeACarLow) {
  RandomStream random(5, "test");
  UprightSight sight = sight_of({{20, 0.2}}, {0, 0}, 20, 0.02, random);
  sight.height_m = 0.65;
  sight.row_gap_m = 0.9;
  const auto height_m = [](UprightSight seen) {
    UprightFilter filter({});
    filter.start(seen, {8, 0});
    for (int scan = 1; scan < 30; ++scan) {
      seen.points.row(0).array() += 0.8;
      seen.stamp_ns += 100'000'000;
      filter.step(scan, seen.stamp_ns, &seen);
    }
    return filter.causal().back().mean[kHeight];
  };
  const double open_m = height_m(sight);
  EXPECT_NEAR(open_m, 1.5, 0.25);
  EXPECT_GT(open_m, height_m(without_gaps(sight)) + 0.1);
}

TEST(UprightSight, BeamsLeaveAnEndOpenAsFarAsTheNextOneIs) {
  RandomStream random(6, "test");
  UprightSight sight = sight_of({{20, 5}}, {0, 0}, 20, 0, random);
  sight.beam_gap_m = 0.1;
  const auto ends = box_ends(sight, 0);
  EXPECT_EQ(ends[0].beyond_m, 0);    // its rear faces the sensor
  EXPECT_GT(ends[1].beyond_m, 0.3);  // along its side, which beams meet under 14 degrees
  EXPECT_LT(ends[1].beyond_m, 0.5);
  EXPECT_EQ(ends[2].beyond_m, 0);            // as does its right
  EXPECT_NEAR(ends[3].beyond_m, 0.1, 0.01);  // across the line of sight
  EXPECT_EQ(without_gaps(sight).beam_gap_m, 0);
}

TEST(UprightFilter, LooksBackWithWhatItLearnsLater) {
  const TurningCar car;
  constexpr int kScans = 40;
  const UprightFilter filter = filter_of(car, {}, kScans);
  const auto causal = filter.causal(), at_once = filter.smoothed(0), lagged = filter.smoothed(1'000'000'000),
             final = filter.smoothed(1'000'000'000'000);
  ASSERT_EQ(final.size(), causal.size());
  double sum_causal_m = 0, sum_final_m = 0;
  for (int i = 0; i < kScans; ++i) {
    EXPECT_EQ(at_once[i].mean, causal[i].mean) << i;
    sum_causal_m += off_m(causal[i], car.at(0.1 * i));
    sum_final_m += off_m(final[i], car.at(0.1 * i));
    for (const int entry : {kX, kY, kLength})
      EXPECT_LE(final[i].covariance(entry, entry), causal[i].covariance(entry, entry) * (1 + 1e-9)) << i;
    EXPECT_NEAR(final[i].mean[kLength], causal.back().mean[kLength], 1e-3) << i;  // bodies are rigid
  }
  EXPECT_LT(sum_final_m, 0.7 * sum_causal_m);
  EXPECT_EQ(final.back().mean, causal.back().mean);
  EXPECT_EQ(lagged.back().mean, causal.back().mean);
  EXPECT_NE(lagged.front().mean, causal.front().mean);
}

// What was seen before it was known to be a body, backwards.
TEST(UprightFilter, GoesBackToWhereItWasSeenFirst) {
  const TurningCar car;
  UprightFilter filter = filter_of(car, {}, 40, 8);
  RandomStream random(4, "test");
  std::vector<UprightFrame> early;
  for (int i = 0; i < 8; ++i) {
    const UprightSight sight = car.sight(i, random);
    early.push_back({sight.frame, sight.stamp_ns, i % 2 ? std::nullopt : std::optional(sight)});
  }
  const auto states = filter.before(filter.smoothed(1'000'000'000'000).front(), early);
  ASSERT_EQ(states.size(), early.size());
  for (int i = 0; i < 8; ++i) {
    EXPECT_EQ(states[i].frame, i);
    EXPECT_EQ(states[i].is_seen, i % 2 == 0);
    EXPECT_LT(off_m(states[i], car.at(0.1 * i)), 0.25) << i;
  }
}

// A neighbour that hangs together with it for some scans makes it no longer.
TEST(UprightFilter, EndsOfAnotherThingAreLeftOut) {
  const TurningCar car;
  RandomStream random(3, "test");
  UprightFilter filter{UprightBoxOptions{}};
  for (int i = 0; i < 40; ++i) {
    UprightSight sight = car.sight(i, random);
    if (i == 30 || i == 31) {
      const auto count = sight.points.cols();
      sight.points.conservativeResize(2, count + 30);
      for (Eigen::Index k = 0; k < 30; ++k)
        sight.points.col(count + k) = car.at(0.1 * i).middle + Vector2d(-7 - 0.02 * k, 2);
      sight.cut.resize(sight.cut.size() + 30, false);
    }
    if (i == 0)
      filter.start(sight, {7.5, 0.5});
    else
      filter.step(sight.frame, sight.stamp_ns, &sight);
  }
  EXPECT_NEAR(filter.causal().back().mean[kLength], 4.4, 0.25);
  EXPECT_LT(off_m(filter.causal().back(), car.at(3.9)), 0.15);
}

}  // namespace
}  // namespace uniquadric
