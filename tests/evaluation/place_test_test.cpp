#include "evaluation/comparison/place_test.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numeric>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;
using Sequences = std::vector<std::vector<double>>;  // losses of one object by seed

MetricChange change_of(const Sequences& sequences) {
  MetricChange change;
  for (const auto& losses : sequences) {
    PlaceChange& place = change.places.emplace_back();
    place.sequence = std::string("s") + static_cast<char>('0' + change.places.size());
    place.object = "cube";
    for (std::size_t seed = 0; seed < losses.size(); ++seed) place.losses[seed + 1] = losses[seed];
    place.loss = std::accumulate(losses.begin(), losses.end(), 0.0) / static_cast<double>(losses.size());
  }
  return change;
}

std::vector<MetricChange> tested(std::vector<MetricChange> changes, std::size_t least_seeds) {
  GateOptions options;
  options.place_seeds = least_seeds;
  test_places(changes, options);
  return changes;
}

Sequences random_losses(std::uint64_t trial, std::size_t sequences, std::size_t seeds) {
  RandomStream random(4, "losses", trial);
  Sequences losses(sequences, std::vector<double>(seeds));
  for (auto& of_sequence : losses)
    for (double& loss : of_sequence) loss = random.normal();
  return losses;
}

// Every seed of a place lost the same: no flip but the observed one has so great a T.
TEST(PlaceTest, TheSameLossOfAllSeeds) {
  const auto changes =
      tested({change_of({std::vector<double>(8, 0.3), {0.1, -0.1, 0.1, -0.1, 0.1, -0.1, 0.1, -0.1}})}, 8);
  EXPECT_NEAR(*changes[0].places[0].p, 1.0 / 256, kRounding);
  EXPECT_GT(*changes[0].places[1].p, 0.3);
}

TEST(PlaceTest, WhatIsNotTestedHasNoP) {
  auto change = change_of({{0.1, 0.2, 0.3}, {0, 0, 0, 0}, {0.1, 0.2, -0.1, 0.1}});
  auto changes = tested({change}, 4);
  EXPECT_FALSE(changes[0].places[0].p);  // too few seeds
  EXPECT_FALSE(changes[0].places[1].p);  // nothing differs
  EXPECT_TRUE(changes[0].places[2].p);
  change.rule.is_time = true;
  EXPECT_FALSE(tested({change}, 4)[0].places[2].p);
}

// T as documented, of flips of all seeds of both sequences at once, counted one by one.
TEST(PlaceTest, AsByAllFlipsOfAllRuns) {
  constexpr int kSeeds = 4;
  const double degrees = kPooledDegreesOfFreedom;
  for (std::uint64_t trial = 0; trial < 20; ++trial) {
    Sequences losses = random_losses(trial, 2, kSeeds);
    for (auto& of_sequence : losses)  // losses in both: nothing is left out as a gain
      if (std::accumulate(of_sequence.begin(), of_sequence.end(), 0.0) < 0)
        for (double& loss : of_sequence) loss = -loss;
    double squares = 0;
    for (const auto& of_sequence : losses)
      for (const double loss : of_sequence) squares += loss * loss / (2 * kSeeds);  // median of two
    const auto t_of = [&](int sequence, int flips) {
      double sum = 0, rest = 0;
      for (int i = 0; i < kSeeds; ++i) sum += (flips >> i & 1 ? -1 : 1) * losses[sequence][i];
      for (int i = 0; i < kSeeds; ++i)
        rest += std::pow((flips >> i & 1 ? -1 : 1) * losses[sequence][i] - sum / kSeeds, 2);
      return sum / kSeeds / std::sqrt((degrees * squares + rest) / (degrees + kSeeds - 1) / kSeeds);
    };
    std::array<int, 2> at_least{};
    for (int both = 0; both < 256; ++both) {
      const double greatest = std::max(t_of(0, both & 15), t_of(1, both >> 4));
      for (int sequence = 0; sequence < 2; ++sequence)
        at_least[sequence] += greatest >= t_of(sequence, 0) - kRounding;
    }
    const auto changes = tested({change_of(losses)}, kSeeds);
    for (int sequence = 0; sequence < 2; ++sequence)
      EXPECT_NEAR(*changes[0].places[sequence].p, at_least[sequence] / 256.0, kRounding) << trial;
  }
}

// Ten metrics that say the same are one: what they have in common is not paid for ten times.
TEST(PlaceTest, MetricsThatSayTheSameAreNotCorrectedFor) {
  const MetricChange change = change_of(random_losses(1, 3, 8));
  const auto one = tested({change}, 8), ten = tested(std::vector(10, change), 8);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(*ten[7].places[i].p, *one[0].places[i].p, kRounding);
  std::vector<MetricChange> others;
  for (std::uint64_t trial = 1; trial <= 10; ++trial) others.push_back(change_of(random_losses(trial, 3, 8)));
  EXPECT_GT(*tested(others, 8)[0].places[0].p, *one[0].places[0].p);
}

TEST(PlaceTest, ManySeedsAreDrawnAndAgreeWithAll) {
  std::vector<double> losses(kMostExactSeeds + 8, 0.01);
  for (std::size_t i = 0; i < losses.size(); i += 2) losses[i] = -0.006;
  const double drawn = *tested({change_of({losses})}, 8)[0].places[0].p;
  EXPECT_GT(drawn, 1.0 / kPlaceFlips);
  // normal theory: T of 20 seeds, mean 0.002, against the usual square of both
  EXPECT_NEAR(drawn, 0.14, 0.03);
  EXPECT_EQ(drawn, *tested({change_of({losses})}, 8)[0].places[0].p);
}

}  // namespace
}  // namespace uniquadric
