#include "simulator/noise/mask_faults.h"

#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "simulator/noise/segmenter.h"
#include "tests/simulator/noise_statistics.h"
#include "tests/simulator/same_image.h"

namespace uniquadric {
namespace {

constexpr int kPeriods = 400;
const std::set<int> kObjects{1, 2, 3};

// Two boxes side by side, and one apart.
cv::Mat three_boxes() {
  cv::Mat ids = cv::Mat::zeros(240, 320, CV_16UC1);
  ids(cv::Rect(40, 60, 50, 80)).setTo(1);
  ids(cv::Rect(90, 60, 50, 80)).setTo(2);
  ids(cv::Rect(220, 60, 50, 80)).setTo(3);
  return ids;
}

template <typename Is>
double share_of_periods(const SegmenterNoise& noise, const Is& is) {
  int count = 0;
  for (int k = 0; k < kPeriods; ++k)
    count += is(mask_faults(three_boxes(), noise, 4, 0.5 * k + 0.1, kObjects));
  return count / static_cast<double>(kPeriods);
}

double slack(double probability) {
  return kSigmas * std::sqrt(probability * (1 - probability) / kPeriods);
}

int area(const cv::Mat& ids, int id) {
  return cv::countNonZero(ids == id);
}

TEST(MaskFaults, NoneLeavesTheIds) {
  EXPECT_TRUE(same(mask_faults(three_boxes(), {}, 4, 1, kObjects), three_boxes()));
}

TEST(MaskFaults, OnlyTouchingMasksMerge) {
  SegmenterNoise noise;
  noise.merge_probability = 0.3;
  const double share = share_of_periods(noise, [](const cv::Mat& ids) {
    EXPECT_EQ(area(ids, 3), 4000);
    EXPECT_EQ(area(ids, 1) + area(ids, 2), 8000);
    return area(ids, 2) == 0;
  });
  EXPECT_NEAR(share, 0.3, slack(0.3));
}

TEST(MaskFaults, SplitMasksFallIntoHalves) {
  SegmenterNoise noise;
  noise.split_probability = 0.3;
  const double share = share_of_periods(noise, [](const cv::Mat& ids) {
    const int rest = area(ids, 3);
    EXPECT_TRUE(rest == 4000 || std::abs(rest - 2000) <= 100) << rest;
    cv::Mat part;
    ids(cv::Rect(220, 60, 50, 80)).copyTo(part);
    EXPECT_EQ(rest + cv::countNonZero(part >= kFirstFalseId), 4000);
    return rest < 4000;
  });
  EXPECT_NEAR(share, 0.3, slack(0.3));
}

// Of three in a row the first and the last may never change places.
TEST(MaskFaults, MergedMasksAreOneWithTheSmallestId) {
  SegmenterNoise noise;
  noise.merge_probability = 0.6;
  cv::Mat row = cv::Mat::zeros(40, 120, CV_16UC1);
  const std::vector<int> ids{2, 3, 1};
  for (int k = 0; k < 3; ++k) row(cv::Rect(20 + 20 * k, 10, 20, 20)).setTo(ids[k]);
  int all = 0;
  for (int k = 0; k < kPeriods; ++k) {
    const cv::Mat seen = mask_faults(row, noise, 4, 0.5 * k, kObjects);
    const int left = seen.at<std::uint16_t>(20, 30), middle = seen.at<std::uint16_t>(20, 50),
              right = seen.at<std::uint16_t>(20, 70);
    EXPECT_EQ(right, 1);
    EXPECT_TRUE(middle == 1 || (left == 2 && (middle == 2 || middle == 3))) << left << ", " << middle;
    EXPECT_TRUE(left == 2 || (left == 1 && middle == 1)) << left << ", " << middle;
    all += left == 1;
  }
  EXPECT_NEAR(all / static_cast<double>(kPeriods), 0.36, slack(0.36));  // each pair of its own
}

TEST(MaskFaults, FalseIdsAreNoObjectsAndDifferByObjectAndTime) {
  const std::set<int> objects{7, 2007, kFirstFalseId, kFirstFalseId + 1, 65000};
  std::set<int> given;
  for (std::uint64_t period = 0; period < 100; ++period)
    for (const int of : {0, 7, 2007, kFirstFalseId, kFirstFalseId + 1, 65000}) {
      const int id = false_id(objects, period, of);
      EXPECT_EQ(id, false_id(objects, period, of));
      EXPECT_GE(id, kFirstFalseId);
      EXPECT_FALSE(objects.contains(id));
      EXPECT_TRUE(given.insert(id).second) << period << ", " << of;
    }
}

TEST(MaskFaults, LeaksRunOverTheBackgroundBelow) {
  SegmenterNoise noise;
  noise.leak_probability = 0.3;
  noise.leak_px = 10;
  const double share = share_of_periods(noise, [](const cv::Mat& ids) {
    const bool leaks = area(ids, 3) == 4000 + 10 * 50;
    EXPECT_TRUE(leaks || area(ids, 3) == 4000);
    EXPECT_EQ(ids.at<std::uint16_t>(149, 230), leaks ? 3 : 0);
    EXPECT_EQ(ids.at<std::uint16_t>(59, 230), 0);
    return leaks;
  });
  EXPECT_NEAR(share, 0.3, slack(0.3));
}

TEST(MaskFaults, FalseMasksTakeBackgroundAlone) {
  SegmenterNoise noise;
  noise.false_probability = 0.3;
  const double share = share_of_periods(noise, [](const cv::Mat& ids) {
    EXPECT_EQ(area(ids, 1) + area(ids, 2) + area(ids, 3), 12000);
    return cv::countNonZero(ids >= kFirstFalseId) > 0;
  });
  EXPECT_GT(share, 0.3 * 0.7);  // some lie behind the boxes
  EXPECT_LT(share, 0.3 + slack(0.3));
}

TEST(MaskFaults, LastHalfASecond) {
  SegmenterNoise noise;
  noise.split_probability = 0.5;
  for (int k = 0; k < 20; ++k)
    EXPECT_TRUE(same(mask_faults(three_boxes(), noise, 4, 0.5 * k + 0.01, kObjects),
                     mask_faults(three_boxes(), noise, 4, 0.5 * k + 0.49, kObjects)));
}

TEST(MaskFaults, OutagesTakeTheirShareOfTheTime) {
  SegmenterNoise noise;
  noise.outage_every_s = 8;
  noise.outage_s = 2;
  int missing = 0, outages = 0;
  bool before = true;
  for (std::int64_t frame = 0; frame < 30 * 80; ++frame) {
    const bool is = is_segmented(noise, 6, frame, 30);
    missing += !is;
    outages += before && !is;
    before = is;
  }
  EXPECT_EQ(outages, 10);
  EXPECT_NEAR(missing, 10 * 60, 10);
}

// One random number for both let none of the lower parts leak.
TEST(MaskFaults, LeaksDoNotDependOnWhichWayASplitGoes) {
  SegmenterNoise noise;
  noise.split_probability = 1;
  noise.leak_probability = 0.5;
  int lower = 0, leaks = 0;
  for (int k = 0; k < kPeriods; ++k) {
    const cv::Mat ids = mask_faults(three_boxes(), noise, 4, 0.5 * k + 0.1, kObjects);
    const cv::Mat kept = ids(cv::Rect(220, 60, 50, 80)) == 3;
    if (2 * cv::countNonZero(kept.rowRange(40, 80)) < cv::countNonZero(kept)) continue;
    ++lower;
    leaks += area(ids, 3) > cv::countNonZero(kept);
  }
  EXPECT_GT(lower, kPeriods / 3);
  EXPECT_NEAR(leaks / static_cast<double>(lower), 0.5, kSigmas * 0.5 / std::sqrt(lower));
}

TEST(MaskFaults, LatencyIsLogNormalWithItsMeanAndDeviation) {
  constexpr int kFrames = 40'000;
  constexpr double kKurtosis = 3.67;  // of the log-normal distribution whose deviation is a fifth of its mean
  SegmenterNoise noise;
  noise.latency_s = 0.1;
  noise.latency_sigma_s = 0.02;
  std::vector<double> late, logarithms;
  for (std::int64_t frame = 0; frame < kFrames; ++frame) {
    late.push_back(latency_s(noise, 2, frame));
    logarithms.push_back(std::log(late.back()));
  }
  EXPECT_NEAR(mean(late), 0.1, kSigmas * 0.02 / std::sqrt(kFrames));
  EXPECT_NEAR(deviation(late) / 0.02, 1, kSigmas * std::sqrt((kKurtosis - 1) / (4 * kFrames)));
  const double expected = std::sqrt(std::log(1.04));
  EXPECT_NEAR(mean(logarithms), std::log(0.1) - 0.5 * expected * expected,
              kSigmas * expected / std::sqrt(kFrames));
  EXPECT_NEAR(deviation(logarithms) / expected, 1, kSigmas / std::sqrt(2 * kFrames));
}

TEST(MaskFaults, LatencyIsNeverNothingUnlessItsMeanIs) {
  SegmenterNoise noise;
  noise.latency_s = 0.1;
  noise.latency_sigma_s = 1;
  for (std::int64_t frame = 0; frame < 1000; ++frame) EXPECT_GT(latency_s(noise, 2, frame), 0);
  noise.latency_sigma_s = 0;
  EXPECT_EQ(latency_s(noise, 2, 7), 0.1);
  noise.latency_sigma_s = 1;
  noise.latency_s = 0;
  EXPECT_EQ(latency_s(noise, 2, 7), 0);
}

}  // namespace
}  // namespace uniquadric
