#include "evaluation/report/trajectory_svg.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "evaluation/report/svg_panel.h"

namespace uniquadric {
namespace {

// Ten poses along x, a metre and a second apart; the last value jumps.
TrajectoryComparison straight_way(const std::vector<double>& errors) {
  TrajectoryComparison c;
  ErrorSeries series;
  for (std::size_t i = 0; i < errors.size(); ++i) {
    c.pairs.stamps_ns.push_back(static_cast<std::int64_t>(i) * 1'000'000'000);
    c.pairs.reference.push_back({Eigen::Quaterniond::Identity(), {static_cast<double>(i), 0, 0}});
    series.at.push_back(i);
    series.values.push_back(errors[i]);
  }
  c.pairs.estimate = c.pairs.reference;
  c.errors = {series};
  return c;
}

std::vector<std::string> coloured_strokes(const std::string& picture) {
  std::vector<std::string> strokes;
  const std::string start = "<path class=\"coloured\" stroke=\"";
  for (std::size_t at = picture.find(start); at != std::string::npos; at = picture.find(start, at + 1))
    strokes.push_back(picture.substr(at + start.size(), picture.find("/>", at) - at - start.size()));
  return strokes;
}

}  // namespace

TEST(SvgPanel, TicksAreRoundAndInside) {
  EXPECT_EQ(round_ticks({0, 10}, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(round_ticks({-1.2, 1.2}, 3), (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(round_ticks({101, 149}, 5), (std::vector<double>{110, 120, 130, 140}));
}

TEST(SvgPanel, RangeHasRoomAlsoForOneValue) {
  EXPECT_DOUBLE_EQ(padded_range({0, 10}).min, -0.5);
  EXPECT_DOUBLE_EQ(padded_range({0, 10}).max, 10.5);
  const SvgRange flat = padded_range({3, 3, 3});
  EXPECT_LT(flat.min, 3);
  EXPECT_GT(flat.max, 3);
}

TEST(SvgPanel, LineMapsValuesAndDropsRepeatedPoints) {
  const SvgPanel panel{100, 10, 200, 50, {0, 2}, {0, 1}};
  EXPECT_EQ(panel_line(panel, {0, 1, 1, 2}, {0, 0.5, 0.5, 1}), "M100.0 60.0L200.0 35.0L300.0 10.0");
}

TEST(TrajectorySvg, ColoursThePathByItsError) {
  const auto strokes = coloured_strokes(trajectory_svg(straight_way({0, 0, 0, 0, 1, 1, 1, 1, 1, 1}), "t"));
  ASSERT_EQ(strokes.size(), 2u);
  EXPECT_TRUE(strokes[0].starts_with("#2c7bb6")) << strokes[0];  // small
  EXPECT_TRUE(strokes[1].starts_with("#c92a2a")) << strokes[1];  // large
  const auto points = [](const std::string& stroke) {
    return std::count(stroke.begin(), stroke.end(), 'L') + 1;
  };
  EXPECT_EQ(points(strokes[0]), 4);  // poses 0 to 3
  EXPECT_EQ(points(strokes[1]), 7);  // from 3 to 9: no hole between them
  EXPECT_EQ(coloured_strokes(trajectory_svg(straight_way({2, 2, 2}), "t")).size(), 1u);
}

TEST(TrajectorySvg, TakesStepsInAnyOrderAndAnyTitle) {
  TrajectoryComparison c = straight_way({0, 0, 0, 1, 1});
  const std::string sorted = trajectory_svg(c, "a<b");
  std::swap(c.errors[0].at[0], c.errors[0].at[4]);
  std::swap(c.errors[0].values[0], c.errors[0].values[4]);
  EXPECT_EQ(trajectory_svg(c, "a<b"), sorted);
  EXPECT_NE(sorted.find(">a&lt;b<"), std::string::npos);
}

}  // namespace uniquadric
