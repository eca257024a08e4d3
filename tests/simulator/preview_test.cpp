#include "simulator/preview.h"

#include <gtest/gtest.h>

#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "core/base/files.h"
#include "simulator/render/renderer.h"
#include "tests/simulator/simple_scene.h"
#include "tests/support/temp_folder.h"

namespace uniquadric {
namespace {

TEST(Preview, ShowsEvenlySpacedFramesSideBySide) {
  const TempFolder temp;
  const Scene scene = two_boxes();  // 12 frames at 10 Hz, 160 x 120
  write_preview(scene, {.frames = 2, .width_px = 324}, temp.path() / "a.jpg");
  const cv::Mat picture = cv::imread((temp.path() / "a.jpg").string());
  ASSERT_EQ(picture.size(), cv::Size(324, 120));
  Renderer renderer(scene);
  for (int i = 0; i < 2; ++i) {
    cv::Mat frame;
    cv::cvtColor(renderer.render(poses_at(scene, 0.3 + 0.6 * i)).rgba, frame, cv::COLOR_RGBA2BGR);
    const cv::Mat difference = picture(cv::Rect(164 * i, 0, 160, 120)) - frame;
    EXPECT_LT(cv::norm(difference, cv::NORM_L1) / (3.0 * 160 * 120), 4) << i;  // grey levels: JPEG
  }
  EXPECT_GT(cv::mean(picture.colRange(161, 163))[0], 240) << "the gap";
  write_preview(scene, {.frames = 2, .width_px = 324}, temp.path() / "b.jpg");
  EXPECT_EQ(read_text(temp.path() / "a.jpg"), read_text(temp.path() / "b.jpg"));
}

TEST(Preview, RefusesMoreFramesThanThereAre) {
  const TempFolder temp;
  EXPECT_NE(input_error([&] {
              write_preview(two_boxes(), {.frames = 13}, temp.path() / "a.jpg");
            }).find("12 frames"),
            std::string::npos);
  EXPECT_NE(input_error([&] {
              write_preview(two_boxes(), {.frames = 3, .width_px = 9}, temp.path() / "a.jpg");
            }).find("do not fit"),
            std::string::npos);
}

}  // namespace
}  // namespace uniquadric
