#include "core/sequence/smeared_edges.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <opencv2/core.hpp>
#include <optional>
#include <vector>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr int kReach = 8;       // px on either side within which a ramp is looked for
constexpr double kStep = 0.1;   // relative: steps that are this clear tell the width
constexpr double kNoises = 6;   // that a step exceeds
constexpr double kSharp = 0.5;  // of a step, between two neighbouring pixels
constexpr double kSide = 0.1;   // of a step: nearer to one side's line than this is that side
constexpr int kApart = 8;       // px between the rows and columns that are looked at
constexpr std::size_t kLeastSteps = 20;
constexpr double kQuantile = 0.25;
constexpr double kMost = 0.8, kMeanOfMost = 0.558;  // of a normal distribution: mean size of the smaller 80 %
constexpr float kBends = 6;                         // of smooth surfaces: a smaller step is none

// Inverse depth along a row or a column; 0 none.
struct Profile {
  const float* first;
  std::ptrdiff_t stride;
  int count;
  float at(int i) const { return first[i * stride]; }
};

Profile row_of(const cv::Mat& w, int v) {
  return {w.ptr<float>(v), 1, w.cols};
}

Profile column_of(const cv::Mat& w, int u) {
  return {w.ptr<float>(0) + u, static_cast<std::ptrdiff_t>(w.step1()), w.rows};
}

struct Line {
  double at_zero, slope;
  double at(double i) const { return at_zero + slope * i; }
};

// Through the samples from `begin` to before `end`; nothing where one has no depth.
std::optional<Line> line(const Profile& profile, int begin, int end) {
  double n = 0, x = 0, xx = 0, w = 0, xw = 0;
  for (int i = begin; i < end; ++i) {
    const double value = profile.at(i);
    if (!(value > 0)) return std::nullopt;
    n += 1, x += i, xx += static_cast<double>(i) * i, w += value, xw += i * value;
  }
  const double slope = (n * xw - x * w) / (n * xx - x * x);
  return Line{(w - slope * x) / n, slope};
}

// Both sides of the place between i - 1 and i.
struct Sides {
  Line before, after;
  double step(double i) const { return std::abs(after.at(i) - before.at(i)); }
};

std::optional<Sides> sides(const Profile& profile, int i) {
  const auto before = line(profile, i - 2 * kReach, i - kReach),
             after = line(profile, i + kReach, i + 2 * kReach);
  if (!before || !after) return std::nullopt;
  return Sides{*before, *after};
}

// Width of the ramp about the step from i - 1 to i. Where the sides' lines meet nearby it is a crease.
std::optional<double> ramp_width(const Profile& profile, int i, double least) {
  const auto s = sides(profile, i);
  if (!s || s->step(i) < std::max(least, kStep * std::max(s->before.at(i), s->after.at(i))))
    return std::nullopt;
  if (s->step(i) < 2 * kReach * std::abs(s->after.slope - s->before.slope)) return std::nullopt;
  const float here = profile.at(i), before = profile.at(i - 1);
  if (here > 0 && before > 0 && std::abs(here - before) > kSharp * s->step(i))
    return 1;  // though a narrow face may be beside it
  int first = i, last = i - 1;
  for (int k = i - kReach; k < i + kReach; ++k) {
    const double w = profile.at(k);
    const double share = (w - s->before.at(k)) / (s->after.at(k) - s->before.at(k));
    if (!(w > 0) || share < kSide || share > 1 - kSide) continue;
    first = std::min(first, k), last = std::max(last, k);
  }
  return last - first + 2;
}

// Widths of the steps: each at its steepest place.
void add_widths(const Profile& profile, double least, std::vector<double>& widths) {
  const auto step = [&](int i) { return std::abs(profile.at(i) - profile.at(i - 1)); };
  for (int i = 2 * kReach; i + 2 * kReach <= profile.count; ++i) {
    const float here = step(i);
    if (!(here > kStep / (2 * kReach) * profile.at(i))) continue;
    bool steepest = true;
    for (int k = i - kReach; k <= i + kReach && steepest; ++k)
      steepest = k < i ? step(k) < here : step(k) <= here;
    if (!steepest) continue;
    if (const auto width = ramp_width(profile, i, least)) widths.push_back(*width);
  }
}

// The sigma of what noise makes of a place without a step.
double step_noise(const cv::Mat& w) {
  std::vector<double> steps;
  for (int v = kApart / 2; v < w.rows; v += kApart)
    for (int u = 2 * kReach; u + 2 * kReach <= w.cols; u += kApart)
      if (const auto s = sides(row_of(w, v), u)) steps.push_back(s->step(u));
  return steps.empty() ? 0 : kMadToSigma * quantile(std::move(steps), 0.5);
}

cv::Mat inverse(const cv::Mat& depth) {
  cv::Mat result;
  cv::divide(1.0, depth, result);
  result.setTo(0, depth <= 0);
  return result;
}

// A profile about a ramp's middle, at its ends and as far from them as they are apart.
struct Ends {
  float before, first, last, after;
  // By how much the change between the ends is beyond the changes on both sides of it: a crease's is between.
  float excess() const {
    const auto [least, most] = std::minmax({first - before, after - last});
    return std::max(last - first - most, least - (last - first));
  }
  float bend() const { return std::abs((last - first) - 0.5F * (after - last + first - before)); }
};

std::optional<Ends> ends(const Profile& profile, int middle, int half) {
  const Ends e{profile.at(middle - 3 * half), profile.at(middle - half), profile.at(middle + half),
               profile.at(middle + 3 * half)};
  if (!(e.before > 0 && e.first > 0 && e.last > 0 && e.after > 0)) return std::nullopt;
  return e;
}

// How much smooth surfaces bend there: by their form and by noise.
float usual_bend(const cv::Mat& w, int half) {
  std::vector<double> bends;
  for (int v = kApart / 2; v < w.rows; v += kApart)
    for (int u = 3 * half; u + 3 * half < w.cols; u += kApart)
      if (const auto e = ends(row_of(w, v), u, half)) bends.push_back(e->bend());
  if (bends.empty()) return 0;
  std::sort(bends.begin(), bends.end());  // the mean of most: a median of whole millimetres may be zero
  const auto most = static_cast<std::ptrdiff_t>(std::ceil(kMost * static_cast<double>(bends.size())));
  const double sum = std::accumulate(bends.begin(), bends.begin() + most, 0.0);
  return static_cast<float>(sum / static_cast<double>(most) / kMeanOfMost);
}

// Marks each ramp about its middle, where the excess is largest.
void mark_ramps(const Profile& profile, int half, float least, std::vector<float>& excess,
                unsigned char* ramp) {
  excess.assign(static_cast<std::size_t>(profile.count), 0);
  for (int i = 3 * half; i + 3 * half < profile.count; ++i)
    if (const auto e = ends(profile, i, half)) excess[i] = e->excess();
  for (int i = 3 * half; i + 3 * half < profile.count; ++i)
    if (excess[i] > least && excess[i] == *std::max_element(&excess[i - half], &excess[i + half + 1]))
      for (int k = i - half; k <= i + half; ++k) ramp[k * profile.stride] = 255;
}

// Marks what is beside a gap longer than a ramp: one end of the ramp may be hidden there.
void mark_beside_gaps(const Profile& profile, int half, unsigned char* ramp) {
  for (int begin = 0, end = 0; begin < profile.count; begin = end + 1) {
    end = begin;
    while (end < profile.count && !(profile.at(end) > 0)) ++end;
    if (end - begin <= 2 * half) continue;
    for (int k = std::max(begin - half, 0); k < std::min(end + half, profile.count); ++k)
      ramp[k * profile.stride] = 255;
  }
}

}  // namespace

void add_edge_widths(const cv::Mat& depth, std::vector<double>& widths_px) {
  const cv::Mat w = inverse(depth);
  const double least = kNoises * step_noise(w);
  for (int v = kApart / 2; v < w.rows; v += kApart) add_widths(row_of(w, v), least, widths_px);
  for (int u = kApart / 2; u < w.cols; u += kApart) add_widths(column_of(w, u), least, widths_px);
}

double usual_edge_width_px(std::vector<double> widths_px) {
  return widths_px.size() < kLeastSteps ? 1 : quantile(std::move(widths_px), kQuantile);
}

void drop_smeared_edges(cv::Mat& depth, double width_px) {
  const int half = static_cast<int>(std::floor(width_px / 2));
  if (half < 1) return;
  const cv::Mat w = inverse(depth);
  const float least = kBends * usual_bend(w, half);
  cv::Mat ramps = cv::Mat::zeros(w.size(), CV_8UC1);
  std::vector<float> excess;
  const auto mark = [&](const Profile& profile, unsigned char* ramp) {
    mark_beside_gaps(profile, half, ramp);
    mark_ramps(profile, half, least, excess, ramp);
  };
  for (int v = 0; v < w.rows; ++v) mark(row_of(w, v), ramps.ptr(v));
  for (int u = 0; u < w.cols; ++u) mark(column_of(w, u), ramps.ptr(0) + u);
  depth.setTo(0, ramps);
}

}  // namespace uniquadric
