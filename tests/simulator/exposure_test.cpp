#include "simulator/noise/exposure.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

const cv::Mat kGrey(60, 80, CV_8UC4, cv::Scalar(80, 100, 60, 7));

TEST(Exposure, FixedExposureChangesNothing) {
  EXPECT_TRUE(same(exposed(kGrey, {}, 1, 2.5), kGrey));
}

TEST(Exposure, AutomaticExposureBringsTheMeanToItsLevel) {
  Imaging imaging;
  imaging.auto_exposure_level = 120;
  const cv::Scalar mean = cv::mean(exposed(kGrey, imaging, 1, 0));
  EXPECT_NEAR((mean[0] + mean[1] + mean[2]) / 3, 120, 1);
  EXPECT_EQ(exposed(kGrey, imaging, 1, 0).at<cv::Vec4b>(0, 0)[3], 7);
  const cv::Mat dark(60, 80, CV_8UC4, cv::Scalar(5, 5, 5, 7));
  EXPECT_EQ(cv::mean(exposed(dark, imaging, 1, 0))[0], 20);  // four times at most
}

TEST(Exposure, DriftHasItsDeviationAndIsSlow) {
  Imaging imaging;
  imaging.exposure_drift = 0.05;
  imaging.white_balance_drift = 0.02;
  std::vector<double> all, red;
  double quickest = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    const auto gains = exposure_gains(imaging, seed, 3);
    all.push_back(std::log(gains[1]));
    red.push_back(std::log(gains[0] / gains[1]));
    quickest = std::max(quickest, std::abs(std::log(exposure_gains(imaging, seed, 3.033)[1] / gains[1])));
  }
  const double slack = kSigmas / std::sqrt(2 * 2000.0);
  EXPECT_NEAR(deviation(all) / 0.05, 1, slack);
  EXPECT_NEAR(deviation(red) / 0.02, 1, slack);
  // six waves of at most 0.5 Hz
  EXPECT_LT(quickest, 0.05 * std::sqrt(12.0) * 2 * M_PI * 0.5 * 0.033);
}

TEST(Exposure, StampsErrByOffsetAndJitter) {
  Imaging imaging;
  imaging.stamp_offset_s = 0.01;
  EXPECT_EQ(stamp_error_s(imaging, 30, 1, 5), 0.01);
  imaging.stamp_jitter_s = 0.002;
  std::vector<double> errors;
  for (std::int64_t frame = 0; frame < 4000; ++frame) errors.push_back(stamp_error_s(imaging, 30, 1, frame));
  EXPECT_NEAR(mean(errors), 0.01, kSigmas * 0.002 / std::sqrt(4000.0));
  EXPECT_NEAR(deviation(errors) / 0.002, 1, kSigmas / std::sqrt(8000.0));
}

// Two images whose stamps cross would be in the wrong order.
TEST(Exposure, StampsKeepTheirOrder) {
  Imaging imaging;
  imaging.stamp_jitter_s = 0.0166;
  double before_s = -1;
  for (std::int64_t frame = 0; frame < 1000; ++frame) {
    const double taken_s = static_cast<double>(frame) / 30 - stamp_error_s(imaging, 30, 1, frame);
    EXPECT_GT(taken_s, before_s);
    before_s = taken_s;
  }
}

// What would saturate at that gain is not lost before the exposure is dimmed.
TEST(Exposure, IsAutomaticBeforeGreySaturates) {
  Imaging imaging;
  imaging.auto_exposure_level = 60;
  cv::Mat image(1, 2, CV_8UC4, cv::Scalar(40, 40, 40, 255));
  image.at<cv::Vec4b>(0, 1) = {80, 80, 80, 255};
  for (const double gain : {1.0, 8.0}) {
    imaging.gain = gain;
    const cv::Mat seen = exposed(image, imaging, 1, 0);
    const double within = gain == 1 ? 1 : 2;  // 8 times is dimmed by a quarter at most
    EXPECT_NEAR(seen.at<cv::Vec4b>(0, 0)[0], 40 * within, 1);
    EXPECT_NEAR(seen.at<cv::Vec4b>(0, 1)[0], 80 * within, 1);
  }
}

}  // namespace
}  // namespace uniquadric
