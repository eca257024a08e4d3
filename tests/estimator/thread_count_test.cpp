// The same bytes for any number of threads.
#include <gtest/gtest.h>

#include <opencv2/core.hpp>

#include "core/base/error.h"
#include "drawn_sequence.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Robustness, JoinedWithTheBackEndTheBytesAreThoseOfAnyNumberOfThreads) {
  const TempFolder temp;
  Sprite blue = kRed;
  blue.id = 2;
  blue.texture = 12;
  blue.corner_px = [](std::int64_t n) { return Eigen::Vector2d(200 - 1.5 * double(n), 120); };
  write_drawn_sequence(temp.path(), {kRed, blue}, 24);
  Variant joined = windows(EgoSource::rgbd);
  joined.feedback = Feedback::backend;
  const Outcome one = run(temp.path(), 1, joined), four = run(temp.path(), 4, joined);
  EXPECT_EQ(one.files, four.files);
  ASSERT_EQ(one.tracks.objects.size(), 2u);
  expect_sane(one.tracks);
  EXPECT_NE(one.files.at("out/run.yaml").find("feedback: backend"), std::string::npos);
  EstimateOptions options;
  options.quiet = true;
  options.perception = temp.path() / "kept";
  const std::string message =
      input_error([&] { estimate(temp.path(), joined, options, temp.path() / "out"); });
  EXPECT_NE(message.find("feedback: backend"), std::string::npos) << message;
  EXPECT_FALSE(fs::exists(temp.path() / "out") || fs::exists(options.perception));
}

TEST(Robustness, ThirtyBodiesHaveTheSameBytesForAnyNumberOfThreads) {
  std::vector<Sprite> crowd;
  for (int i = 0; i < 30; ++i) {
    const Eigen::Vector2d home(8 + 52 * (i % 6), 6 + 47 * (i / 6));
    const double way = i % 2 ? 0.5 : -0.5;
    crowd.push_back({i + 1,
                     40U + static_cast<std::uint32_t>(i),
                     {40.F + 6 * static_cast<float>(i), 200.F - 5 * static_cast<float>(i), 90},
                     {40, 36},
                     1.5 + 0.05 * i,
                     [=](std::int64_t n) { return Eigen::Vector2d(home.x() + way * double(n), home.y()); }});
  }
  const TempFolder temp;
  write_drawn_sequence(temp.path(), crowd, 12);
  const Outcome one = run(temp.path(), 1), two = run(temp.path(), 2);
  EXPECT_EQ(one.tracks.objects.size(), 30u);
  expect_sane(one.tracks);
  EXPECT_EQ(one.files, two.files);
}

}  // namespace
}  // namespace uniquadric
