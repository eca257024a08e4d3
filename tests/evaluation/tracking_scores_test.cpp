// HOTA, MOTA and IDF1 a second way, by trying every assignment, on random tables of overlaps.
#include "evaluation/association/tracking_scores.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kRounding = 1e-12;
using Pairs = std::vector<std::pair<std::size_t, std::size_t>>;
using Weight = std::function<double(std::size_t, std::size_t)>;

// The assignment with the greatest sum of weights above 0.
struct Search {
  std::size_t rows, columns;
  const Weight& weight;
  std::vector<bool> taken = std::vector<bool>(columns);
  Pairs pairs = {}, best = {};
  double most = -1;

  void from(std::size_t row, double sum) {
    if (row == rows) {
      if (sum > most) most = sum, best = pairs;
      return;
    }
    from(row + 1, sum);
    for (std::size_t column = 0; column < columns; ++column) {
      const double w = taken[column] ? 0 : weight(row, column);
      if (w <= 0) continue;
      taken[column] = true;
      pairs.emplace_back(row, column);
      from(row + 1, sum + w);
      pairs.pop_back();
      taken[column] = false;
    }
  }
};

Pairs assign(const ObjectOverlaps& o, const Weight& weight) {
  Search search{o.truth.size(), o.estimate.size(), weight};
  search.from(0, 0);
  return search.best;
}

double count(const std::vector<std::optional<std::size_t>>& states) {
  return static_cast<double>(
      std::count_if(states.begin(), states.end(), [](const auto& state) { return state.has_value(); }));
}

double count_all(const std::vector<std::vector<std::optional<std::size_t>>>& presence) {
  double n = 0;
  for (const auto& states : presence) n += count(states);
  return n;
}

double mota(const ObjectOverlaps& o) {
  std::vector<int> last(o.truth.size(), -1), kept = last;
  double hits = 0, switches = 0;
  for (std::size_t f = 0; f < o.stamps_ns.size(); ++f) {
    const auto is_there = [&](const auto& states) { return states[f].has_value(); };
    if (std::none_of(o.truth.begin(), o.truth.end(), is_there)) continue;
    if (std::none_of(o.estimate.begin(), o.estimate.end(), is_there)) continue;
    const Pairs pairs = assign(o, [&](std::size_t g, std::size_t e) {
      const double s = o.iou3d[g][e][f];
      return s < kClearThreshold ? 0 : s + (kept[g] == static_cast<int>(e) ? 1000 : 0);
    });
    kept.assign(o.truth.size(), -1);
    for (const auto& [g, e] : pairs) {
      ++hits;
      switches += last[g] >= 0 && last[g] != static_cast<int>(e);
      last[g] = kept[g] = static_cast<int>(e);
    }
  }
  const double truths = count_all(o.truth);
  return 1 - (truths - hits + count_all(o.estimate) - hits + switches) / truths;
}

double idf1(const ObjectOverlaps& o) {
  double hits = 0;
  const auto together = [&](std::size_t g, std::size_t e) {
    return static_cast<double>(std::count_if(o.iou3d[g][e].begin(), o.iou3d[g][e].end(),
                                             [](double s) { return s >= kClearThreshold; }));
  };
  for (const auto& [g, e] : assign(o, together)) hits += together(g, e);
  return 2 * hits / (count_all(o.truth) + count_all(o.estimate));
}

// How much of all that a pair could have in common it has, whatever the threshold.
double fit_over_time(const ObjectOverlaps& o, std::size_t g, std::size_t e) {
  double common = 0;
  for (std::size_t f = 0; f < o.stamps_ns.size(); ++f) {
    const double s = o.iou3d[g][e][f];
    double others = -s;
    for (std::size_t i = 0; i < o.truth.size(); ++i) others += o.iou3d[i][e][f];
    for (std::size_t i = 0; i < o.estimate.size(); ++i) others += o.iou3d[g][i][f];
    if (s > 0) common += s / others;
  }
  return common / (count(o.truth[g]) + count(o.estimate[e]) - common);
}

double hota(const ObjectOverlaps& o) {
  double sum = 0;
  std::vector<std::vector<double>> fit(o.truth.size(), std::vector<double>(o.estimate.size()));
  for (std::size_t g = 0; g < fit.size(); ++g)
    for (std::size_t e = 0; e < fit[g].size(); ++e) fit[g][e] = fit_over_time(o, g, e);
  std::vector<Pairs> frames;
  for (std::size_t f = 0; f < o.stamps_ns.size(); ++f)
    frames.push_back(assign(o, [&](std::size_t g, std::size_t e) { return fit[g][e] * o.iou3d[g][e][f]; }));
  for (int k = 1; k <= 19; ++k) {
    std::map<std::pair<std::size_t, std::size_t>, double> hits;  // TPA of each pair
    double all = 0;
    for (std::size_t f = 0; f < frames.size(); ++f)
      for (const auto& pair : frames[f])
        if (o.iou3d[pair.first][pair.second][f] >= 0.05 * k) ++hits[pair], ++all;
    double association = 0;
    for (const auto& [pair, n] : hits) {
      const double missed = count(o.truth[pair.first]) - n, wrong = count(o.estimate[pair.second]) - n;
      association += n * n / (n + missed + wrong);
    }
    if (all > 0) sum += std::sqrt(association / (count_all(o.truth) + count_all(o.estimate) - all));
  }
  return sum / 19;
}

// Tracks that follow an object more or less and now and then change it, all of them with gaps, and frames
// without any.
ObjectOverlaps random_overlaps(std::uint64_t trial) {
  RandomStream random(5, "tracking scores", trial);
  const auto up_to = [&](int n) { return static_cast<std::size_t>(random.uniform(0, n - 1e-9)); };
  const std::size_t frames = 3 + up_to(25), truths = 1 + up_to(4), estimates = up_to(6);
  const double present = random.uniform(0.3, 1);
  ObjectOverlaps o;
  const auto add = [&](auto& list) {
    auto& states = list.emplace_back(frames);
    for (auto& state : states)
      if (random.uniform() < present) state = 0;
    states[0] = 0;
  };
  for (std::size_t g = 0; g < truths; ++g) add(o.truth);
  for (std::size_t e = 0; e < estimates; ++e) add(o.estimate);
  for (std::size_t f = 0; f < frames; ++f) {
    o.stamps_ns.push_back(static_cast<std::int64_t>(f));
    const bool no_track = f > 0 && random.uniform() < 0.15;
    for (auto& states : o.estimate)
      if (no_track) states[f] = std::nullopt;
  }
  o.iou3d.assign(truths, std::vector(estimates, std::vector<double>(frames)));
  for (std::size_t e = 0; e < estimates; ++e) {
    std::size_t followed = up_to(static_cast<int>(truths));
    for (std::size_t f = 0; f < frames; ++f) {
      if (random.uniform() < 0.1) followed = up_to(static_cast<int>(truths));
      for (std::size_t g = 0; g < truths; ++g)
        if (o.truth[g][f] && o.estimate[e][f])
          o.iou3d[g][e][f] =
              g == followed ? random.uniform(0.2, 1) : std::max(0.0, random.uniform(-0.5, 0.7));
    }
  }
  return o;
}

TEST(TrackingScores, AreThoseOfEveryAssignmentTried) {
  int cases = 0, with_switches = 0;
  for (std::uint64_t trial = 0; trial < 300; ++trial) {
    const ObjectOverlaps o = random_overlaps(trial);
    const auto scores = tracking_scores(o);
    ASSERT_TRUE(scores.has_value());
    EXPECT_NEAR(scores->hota, hota(o), kRounding) << trial;
    EXPECT_NEAR(scores->mota, mota(o), kRounding) << trial;
    EXPECT_NEAR(scores->idf1, idf1(o), kRounding) << trial;
    ++cases;
    for (const int n : identity_switches(o, kClearThreshold)) with_switches += n > 0;
  }
  EXPECT_EQ(cases, 300);
  EXPECT_GT(with_switches, 100);
}

// Two tracks overlap one object, the second better from frame 2 on. The first was matched and is kept, also
// when no track at all is there in between: TrackEval's rule.
TEST(TrackingScores, AFrameWithoutTracksEndsNoMatch) {
  ObjectOverlaps o;
  o.stamps_ns = {0, 1, 2};
  o.truth = {{0, 0, 0}};
  o.estimate = {{0, std::nullopt, 0}, {0, std::nullopt, 0}};
  o.iou3d = {{{0.9, 0, 0.6}, {0.1, 0, 0.8}}};
  EXPECT_EQ(identity_switches(o, kClearThreshold), std::vector<int>{0});
  // hits 2 of 3, 2 false tracks
  EXPECT_NEAR(tracking_scores(o)->mota, 1 - (1 + 2) / 3.0, kRounding);
}

}  // namespace
}  // namespace uniquadric
