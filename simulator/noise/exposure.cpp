#include "simulator/noise/exposure.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "core/base/random.h"

namespace uniquadric {
namespace {

constexpr double kMostStampError = 0.49;  // of the time between two frames: less than half keeps their order

// Unit variance: n sinusoids of amplitude sqrt(2 / n).
double slow_change(std::uint64_t seed, std::uint32_t channel, double time_s) {
  constexpr int kWaves = 6;
  RandomStream random(seed, "exposure", 0, channel);
  double sum = 0;
  for (int i = 0; i < kWaves; ++i) {
    const double frequency_hz = 0.05 * std::pow(10, random.uniform());
    sum += std::sin(2 * std::numbers::pi * (frequency_hz * time_s + random.uniform()));
  }
  return sum * std::sqrt(2.0 / kWaves);
}

double automatic_gain(const cv::Mat& rgba, double gain, double level) {
  const cv::Scalar mean = cv::mean(rgba);
  const double grey = gain * (mean[0] + mean[1] + mean[2]) / 3;
  return grey > 0 ? std::clamp(level / grey, 0.25, 4.0) : 1;
}

}  // namespace

std::array<double, 3> exposure_gains(const Imaging& imaging, std::uint64_t seed, double time_s) {
  const double all = imaging.exposure_drift * slow_change(seed, 0, time_s);
  const double red = imaging.white_balance_drift * slow_change(seed, 1, time_s);
  const double blue = imaging.white_balance_drift * slow_change(seed, 2, time_s);
  return {std::exp(all + red), std::exp(all), std::exp(all + blue)};
}

cv::Mat exposed(const cv::Mat& rgba, const Imaging& imaging, std::uint64_t seed, double time_s) {
  if (!imaging.changes_exposure()) return rgba;
  const auto gains = exposure_gains(imaging, seed, time_s);
  double all = imaging.gain;
  if (imaging.auto_exposure_level > 0) all *= automatic_gain(rgba, all, imaging.auto_exposure_level);
  cv::Mat levels(1, 256, CV_8UC4);
  for (int i = 0; i < 256; ++i)
    for (int channel = 0; channel < 4; ++channel)
      levels.at<cv::Vec4b>(0, i)[channel] =
          cv::saturate_cast<std::uint8_t>(channel < 3 ? all * gains[channel] * i : i);
  cv::Mat result;
  cv::LUT(rgba, levels, result);
  return result;
}

double stamp_error_s(const Imaging& imaging, double rate_hz, std::uint64_t seed, std::int64_t frame) {
  if (imaging.stamp_jitter_s <= 0) return imaging.stamp_offset_s;
  RandomStream random(seed, "stamp", static_cast<std::uint64_t>(frame));
  const double most_s = kMostStampError / rate_hz;
  return std::clamp(imaging.stamp_offset_s + imaging.stamp_jitter_s * random.normal(), -most_s, most_s);
}

}  // namespace uniquadric
