#include "simulator/noise/image_noise.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simulator/noise/normals.h"
#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

TEST(Normals, QuantileInvertsTheDistribution) {
  for (const double p : {1e-9, 0.001, 0.3, 0.5, 0.9, 0.99999})
    EXPECT_NEAR(normal_cdf(normal_quantile(p)) / p, 1, 1e-12);    // some roundings of erfc
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);  // tables
}

TEST(Normals, FollowTheNormalDistributionInBulkAndTail) {
  constexpr int kCount = 4'000'000;
  std::vector<float> values(kCount);
  RandomStream stream(3, "test");
  fill_normals(stream, values);
  const std::vector<double> x(values.begin(), values.end());
  EXPECT_NEAR(mean(x), 0, kSigmas / std::sqrt(kCount));
  EXPECT_NEAR(deviation(x), 1, 1e-4 + kSigmas / std::sqrt(2.0 * kCount));
  constexpr double kFirst = -4.5, kStep = 0.125;  // 45 draws beyond 4.5 are expected
  constexpr int kBins = 74;
  std::vector<double> counts(kBins), expected(kBins);
  for (const double v : x)
    ++counts[std::clamp(static_cast<int>(std::floor((v - kFirst) / kStep)) + 1, 0, kBins - 1)];
  for (int i = 0; i < kBins; ++i) {
    const double low = kFirst + (i - 1) * kStep;
    expected[i] = kCount * ((i == kBins - 1 ? 1 : normal_cdf(low + kStep)) - (i == 0 ? 0 : normal_cdf(low)));
  }
  expect_chi_square(counts, expected);
}

cv::Mat add_image_noise(const cv::Mat& image, const ImageNoise& noise, std::uint64_t seed,
                        std::int64_t frame) {
  cv::Mat noisy = image.clone();
  ImageNoiseSource source(noise, seed);
  for (int v = 0; v < noisy.rows; ++v)
    source.add_to_row(frame, v, {noisy.ptr(v), noisy.elemSize() * static_cast<std::size_t>(noisy.cols)});
  return noisy;
}

TEST(ImageNoise, IsRoundedGaussianNoise) {
  const ImageNoise noise{2.3};
  const cv::Mat grey(480, 641, CV_8UC3, cv::Scalar::all(128));
  const cv::Mat noisy = add_image_noise(grey, noise, 1, 5);
  const auto count = static_cast<double>(noisy.total() * 3);
  constexpr int kReach = 8;  // pooled beyond: 3.7 sigma, some 200 draws
  std::vector<double> counts(2 * kReach + 1), expected(2 * kReach + 1);
  for (auto p = noisy.datastart; p != noisy.dataend; ++p)
    ++counts[std::clamp(*p - 128, -kReach, kReach) + kReach];
  for (int i = -kReach; i <= kReach; ++i)
    expected[i + kReach] = count * ((i == kReach ? 1 : normal_cdf((i + 0.5) / noise.sigma)) -
                                    (i == -kReach ? 0 : normal_cdf((i - 0.5) / noise.sigma)));
  expect_chi_square(counts, expected);
}

TEST(ImageNoise, StopsAtBlackAndWhiteAndDependsOnSeedAndFrame) {
  cv::Mat image(64, 64, CV_8UC3, cv::Scalar(0, 255, 100));
  const cv::Mat noisy = add_image_noise(image, {40}, 1, 5);
  double darkest = 0, brightest = 0;
  cv::minMaxIdx(noisy.reshape(1), &darkest, &brightest);
  EXPECT_EQ(darkest, 0);
  EXPECT_EQ(brightest, 255);
  EXPECT_EQ(noisy.at<cv::Vec3b>(0, 0)[0] < 200 && noisy.at<cv::Vec3b>(0, 0)[1] > 55, true);  // no wrap around
  EXPECT_TRUE(same(noisy, add_image_noise(image, {40}, 1, 5)));
  EXPECT_FALSE(same(noisy, add_image_noise(image, {40}, 2, 5)));
  EXPECT_FALSE(same(noisy, add_image_noise(image, {40}, 1, 6)));
  EXPECT_TRUE(same(image, add_image_noise(image, {0}, 1, 5)));
}

TEST(ImageNoise, ShotNoiseAddsAVarianceInProportionToTheSignal) {
  const ImageNoise noise{1.5, 8};
  int cases = 0;
  for (const int value : {0, 40, 120, 200}) {
    const cv::Mat grey(480, 640, CV_8UC3, cv::Scalar::all(value));
    const cv::Mat noisy = add_image_noise(grey, noise, 1, 5);
    const std::vector<double> x(noisy.datastart, noisy.dataend);
    const double variance = 1.5 * 1.5 + value / 8.0 + 1 / 12.0;  // Sheppard: rounding adds 1/12
    if (value == 0) {                                            // the half below black is cut off
      EXPECT_NEAR(mean(x), 1.5 / std::sqrt(2 * std::numbers::pi), 0.02);
    } else {
      EXPECT_NEAR(mean(x), value, kSigmas * std::sqrt(variance / count_of(x)));
      EXPECT_NEAR(deviation(x) / std::sqrt(variance), 1, 2e-4 + kSigmas / std::sqrt(2 * count_of(x)))
          << value;
    }
    ++cases;
  }
  EXPECT_EQ(cases, 4);
}

TEST(ImageNoise, IsWhite) {
  const cv::Mat grey(256, 256, CV_8UC3, cv::Scalar::all(128));
  const cv::Mat noisy = add_image_noise(grey, {3}, 1, 5).reshape(1);
  const double count = static_cast<double>(noisy.total());
  const auto correlation = [&](int dx, int dy) {
    double sum = 0;
    for (int v = 0; v + dy < noisy.rows; ++v)
      for (int u = 0; u + dx < noisy.cols; ++u)
        sum += (noisy.at<std::uint8_t>(v, u) - 128.0) * (noisy.at<std::uint8_t>(v + dy, u + dx) - 128.0);
    return sum / count / (9 + 1 / 12.0);  // Sheppard: rounding adds 1/12
  };
  for (const auto& [dx, dy] : {std::pair{1, 0}, {2, 0}, {3, 0}, {0, 1}, {0, 2}})
    EXPECT_NEAR(correlation(dx, dy), 0, kSigmas / std::sqrt(count)) << dx << ", " << dy;
}

}  // namespace
}  // namespace uniquadric
