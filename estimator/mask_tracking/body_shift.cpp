#include "estimator/mask_tracking/body_shift.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <utility>
#include <vector>

#include "core/base/quantile.h"

namespace uniquadric {
namespace {

constexpr std::size_t kSamples = 150;  // of a mask's pixels, evenly spread: a shift has few unknowns
constexpr double kTurnStep_rad = 0.3;  // ours: half of it moves the end of a square by a tenth of its side

struct Sample {
  cv::Point pixel;
  cv::Vec3b rgb;
  float z = 0;
};

std::vector<Sample> samples_of(const cv::Mat& mask, const SmallImage& image) {
  std::vector<cv::Point> pixels;
  cv::findNonZero(mask, pixels);
  const std::size_t step = std::max<std::size_t>(1, pixels.size() / kSamples);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < pixels.size(); i += step)
    samples.push_back({pixels[i], image.rgb.at<cv::Vec3b>(pixels[i]),
                       image.depth.empty() ? 0.0F : image.depth.at<float>(pixels[i])});
  return samples;
}

float difference(const cv::Vec3b& a, const cv::Vec3b& b) {
  return static_cast<float>(std::abs(a[0] - b[0]) + std::abs(a[1] - b[1]) + std::abs(a[2] - b[2]));
}

double likeness(float color_difference, double color_scale) {
  return std::max(0.0, 1 - color_difference / color_scale);
}

// What the samples meet at one place: how far their colours are off, and by how much their depth changed.
struct Meeting {
  std::vector<float> color, depth;  // depth: relative; NaN where it is not measured
};

// The samples where the shift's turn takes them.
std::vector<Sample> turned(std::vector<Sample> samples, const BodyShift& turn) {
  for (Sample& sample : samples) sample.pixel = turn.moved(sample.pixel);
  return samples;
}

// From none to the most, either way.
std::vector<double> turns_within(double most_rad) {
  std::vector<double> turns{0};
  for (double turn = kTurnStep_rad; turn < most_rad + kTurnStep_rad / 2; turn += kTurnStep_rad)
    turns.insert(turns.end(), {turn, -turn});
  return turns;
}

cv::Point2f middle_of(const std::vector<Sample>& samples) {
  cv::Point sum;
  for (const Sample& sample : samples) sum += sample.pixel;
  return cv::Point2f(sum) / static_cast<float>(samples.size());
}

cv::Point2f rotated(const cv::Point2f& place, double angle_rad) {
  const auto c = static_cast<float>(std::cos(angle_rad)), s = static_cast<float>(std::sin(angle_rad));
  return {c * place.x - s * place.y, s * place.x + c * place.y};
}

void meet(const std::vector<Sample>& samples, const SmallImage& to, const cv::Point& shift,
          Meeting& meeting) {
  const cv::Rect image({0, 0}, to.rgb.size());
  meeting.color.clear();
  meeting.depth.clear();
  for (const Sample& sample : samples) {
    const cv::Point at = sample.pixel + shift;
    if (!image.contains(at)) continue;
    const float z = to.depth.empty() ? 0.0F : to.depth.at<float>(at);
    meeting.color.push_back(difference(sample.rgb, to.rgb.at<cv::Vec3b>(at)));
    meeting.depth.push_back(z > 0 && sample.z > 0 ? z / sample.z - 1
                                                  : std::numeric_limits<float>::quiet_NaN());
  }
}

// The body's own change of depth: the median of what may be one.
float body_change(const std::vector<float>& depth, double most) {
  std::vector<float> changes;
  for (const float change : depth)
    if (std::abs(change) < most) changes.push_back(change);
  if (changes.empty()) return 0;
  return upper_median(std::move(changes));
}

// How much of the body is seen again: each sample counts by how near its colours are, on the scale of those
// of any place.
double seen_again(const Meeting& meeting, double color_scale, const DepthAgreement& agreement) {
  const float change = body_change(meeting.depth, agreement.most_change);
  double sum = 0;
  for (std::size_t i = 0; i < meeting.color.size(); ++i) {
    if (std::abs(meeting.depth[i] - change) > agreement.tolerance) continue;  // NaN: its colours count alone
    sum += likeness(meeting.color[i], color_scale);
  }
  return sum;
}

std::vector<cv::Point> shifts_within(int reach) {
  std::vector<cv::Point> shifts;
  for (int y = -reach; y <= reach; ++y)
    for (int x = -reach; x <= reach; ++x) shifts.emplace_back(x, y);
  return shifts;
}

// The mean difference of colour over all of these places.
double usual_difference(const std::vector<Sample>& samples, const SmallImage& to,
                        const std::vector<cv::Point>& shifts) {
  double sum = 0;
  std::size_t count = 0;
  Meeting meeting;
  for (const cv::Point& shift : shifts) {
    meet(samples, to, shift, meeting);
    for (const float color : meeting.color) sum += color;
    count += meeting.color.size();
  }
  return count > 0 ? std::max(1.0, sum / static_cast<double>(count)) : 1;
}

}  // namespace

double color_likeness(const cv::Vec3b& a, const cv::Vec3b& b, double color_scale) {
  return likeness(difference(a, b), color_scale);
}

cv::Point2f BodyShift::moved(const cv::Point2f& from) const {
  return rotated(from - middle, turn_rad) + middle + cv::Point2f(pixels);
}

cv::Point2f BodyShift::origin_of(const cv::Point2f& to) const {
  return rotated(to - cv::Point2f(pixels) - middle, -turn_rad) + middle;
}

BodyShift body_shift(const cv::Mat& mask, const SmallImage& from, const SmallImage& to,
                     const DepthAgreement& agreement, double most_turn_rad) {
  const cv::Rect box = cv::boundingRect(mask);
  if (box.empty()) return {};
  const auto samples = samples_of(mask, from);
  const auto shifts = shifts_within(std::max(box.width, box.height));
  const BodyShift none{{}, 0, middle_of(samples), usual_difference(samples, to, shifts)};
  BodyShift best = none;
  double most = -1;
  Meeting meeting;
  for (const double turn_rad : turns_within(most_turn_rad)) {
    BodyShift tried = none;
    tried.turn_rad = turn_rad;
    const auto there = turned(samples, tried);
    for (const cv::Point& shift : shifts) {
      meet(there, to, shift, meeting);
      const double seen = seen_again(meeting, none.color_scale, agreement);
      const bool is_nearer = turn_rad == best.turn_rad && shift.dot(shift) < best.pixels.dot(best.pixels);
      if (seen < most || (seen == most && !is_nearer)) continue;
      most = seen;
      best = tried;
      best.pixels = shift;
    }
  }
  return best;
}

}  // namespace uniquadric
