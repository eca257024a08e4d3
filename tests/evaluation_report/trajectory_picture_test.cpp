#include "evaluation/report/trajectory_picture.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgcodecs.hpp>

#include "evaluation/report/plot_panel.h"

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

std::string svg_of(const TrajectoryComparison& c, const std::string& title) {
  return picture_svg(trajectory_picture(c, title));
}

cv::Mat png_of(const Picture& picture) {
  const std::string bytes = picture_png(picture);
  EXPECT_TRUE(bytes.starts_with("\x89PNG\r\n"));
  return cv::imdecode(std::vector<char>(bytes.begin(), bytes.end()), cv::IMREAD_COLOR);
}

// Blue, green, red at a point of the picture.
cv::Vec3b colour_at(const cv::Mat& image, double x, double y) {
  return image.at<cv::Vec3b>(static_cast<int>(2 * y), static_cast<int>(2 * x));
}

// Of a rectangle of the picture the share of points that are not white.
double ink(const cv::Mat& image, double x, double y, double width, double height) {
  const cv::Mat part = image(cv::Rect2d(2 * x, 2 * y, 2 * width, 2 * height));
  int inked = 0;
  for (int v = 0; v < part.rows; ++v)
    for (int u = 0; u < part.cols; ++u) inked += part.at<cv::Vec3b>(v, u) != cv::Vec3b(255, 255, 255);
  return static_cast<double>(inked) / static_cast<double>(part.total());
}

}  // namespace

TEST(PicturePng, HasEachPartWhereItIs) {
  Picture picture{100, 60, "", {}};
  picture.parts.emplace_back(PictureBox{{10, 10}, 20, 5, "#2c7bb6"});
  picture.parts.emplace_back(PictureLine{LineKind::coloured, {{40, 12}, {90, 12}}, "#c92a2a"});
  picture.parts.emplace_back(PictureLine{LineKind::reference, {{10, 30}, {50, 30}, {90, 30}}, ""});
  picture.parts.emplace_back(PictureText{TextKind::title, TextAnchor::end, {90, 52}, "end"});
  const cv::Mat image = png_of(picture);
  ASSERT_EQ(image.size(), cv::Size(200, 120));
  EXPECT_EQ(colour_at(image, 2, 2), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(colour_at(image, 20, 12), cv::Vec3b(0xb6, 0x7b, 0x2c));
  EXPECT_EQ(colour_at(image, 20, 15.5), cv::Vec3b(255, 255, 255));
  EXPECT_EQ(colour_at(image, 60, 12), cv::Vec3b(0x2a, 0x2a, 0xc9));
  // of 80 units dashes of 5 with pauses of 3, going on through the corner
  int drawn = 0;
  for (double x = 10.25; x < 90; x += 0.5) drawn += colour_at(image, x, 30) != cv::Vec3b(255, 255, 255);
  EXPECT_NEAR(drawn / 160.0, 5.0 / 8, 0.15);
  EXPECT_GT(ink(image, 70, 42, 20, 10), 0.1);  // the text ends at 90
  EXPECT_EQ(ink(image, 92, 40, 8, 20), 0);
  EXPECT_EQ(ink(image, 0, 40, 50, 20), 0);
}

TEST(PicturePng, ATrajectoryIsTheSameBytesAndHasItsColours) {
  const Picture picture = trajectory_picture(straight_way({0, 0, 0, 0, 1, 1, 1, 1, 1, 1}), "t");
  const std::string bytes = picture_png(picture);
  EXPECT_EQ(bytes, picture_png(picture));
  const cv::Mat image = png_of(picture);
  EXPECT_EQ(image.cols, 2 * 940);
  int small = 0, large = 0;
  for (int v = 0; v < image.rows; ++v)
    for (int u = 2 * 62; u < 2 * 462; ++u) {  // left of the colour bar
      small += image.at<cv::Vec3b>(v, u) == cv::Vec3b(0xb6, 0x7b, 0x2c);
      large += image.at<cv::Vec3b>(v, u) == cv::Vec3b(0x2a, 0x2a, 0xc9);
    }
  EXPECT_GT(small, 200);  // a third of the way, in pixels
  EXPECT_GT(large, 2 * small * 9 / 10);
}

TEST(PlotPanel, TicksAreRoundAndInside) {
  EXPECT_EQ(round_ticks({0, 10}, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  EXPECT_EQ(round_ticks({-1.2, 1.2}, 3), (std::vector<double>{-1, 0, 1}));
  EXPECT_EQ(round_ticks({101, 149}, 5), (std::vector<double>{110, 120, 130, 140}));
}

TEST(PlotPanel, RangeHasRoomAlsoForOneValue) {
  EXPECT_DOUBLE_EQ(padded_range({0, 10}).min, -0.5);
  EXPECT_DOUBLE_EQ(padded_range({0, 10}).max, 10.5);
  const PlotRange flat = padded_range({3, 3, 3});
  EXPECT_LT(flat.min, 3);
  EXPECT_GT(flat.max, 3);
}

TEST(PlotPanel, LineMapsValuesAndDropsRepeatedPoints) {
  const PlotPanel panel{100, 10, 200, 50, {0, 2}, {0, 1}};
  const std::vector<PicturePoint> line = {{100, 60}, {200, 35}, {300, 10}};
  EXPECT_EQ(panel_line(panel, {0, 1, 1, 2}, {0, 0.5, 0.5, 1}), line);
}

TEST(TrajectoryPicture, ColoursThePathByItsError) {
  const auto strokes = coloured_strokes(svg_of(straight_way({0, 0, 0, 0, 1, 1, 1, 1, 1, 1}), "t"));
  ASSERT_EQ(strokes.size(), 2u);
  EXPECT_TRUE(strokes[0].starts_with("#2c7bb6")) << strokes[0];  // small
  EXPECT_TRUE(strokes[1].starts_with("#c92a2a")) << strokes[1];  // large
  const auto points = [](const std::string& stroke) {
    return std::count(stroke.begin(), stroke.end(), 'L') + 1;
  };
  EXPECT_EQ(points(strokes[0]), 4);  // poses 0 to 3
  EXPECT_EQ(points(strokes[1]), 7);  // from 3 to 9: no hole between them
  EXPECT_EQ(coloured_strokes(svg_of(straight_way({2, 2, 2}), "t")).size(), 1u);
}

TEST(TrajectoryPicture, TakesStepsInAnyOrderAndAnyTitle) {
  TrajectoryComparison c = straight_way({0, 0, 0, 1, 1});
  const std::string sorted = svg_of(c, "a<b");
  std::swap(c.errors[0].at[0], c.errors[0].at[4]);
  std::swap(c.errors[0].values[0], c.errors[0].values[4]);
  EXPECT_EQ(svg_of(c, "a<b"), sorted);
  EXPECT_NE(sorted.find(">a&lt;b<"), std::string::npos);
}

}  // namespace uniquadric
