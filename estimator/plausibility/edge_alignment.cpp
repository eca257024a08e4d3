#include "estimator/plausibility/edge_alignment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr int kWidth_px = 320;            // that images are thinned out to
constexpr double kJump = 0.05;            // of depth between neighbours, relative: an edge
constexpr int kHole_px = 4;               // without depth at an edge, at most
constexpr int kReach_px = 10;             // of shifts that are tried
constexpr int kSameShift_px = 2;          // registered all the same
constexpr int kMostLate = 6;              // frames
constexpr std::size_t kLeastEdges = 100;  // in a frame
constexpr std::size_t kLeastFrames = 4;
// How much better another alignment must be, as a multiple of the contrast as it is, and how clear: the edges
// of a few small masks lie on many others by chance.
struct Clarity {
  double better = 1.35, contrast = 0.1;
};
constexpr Clarity kOfDepth, kOfMasks{2.2, 0.15};
constexpr double kMostFrames = 0.7;  // of the frames must agree

using Points = std::vector<cv::Point>;

int thinning(const cv::Size& size) {
  return std::max(1, size.width / kWidth_px);
}

// Pixels of every so manyth row and column.
cv::Mat thinned_out(const cv::Mat& full) {
  cv::Mat result;
  cv::resize(full, result, full.size() / thinning(full.size()), 0, 0, cv::INTER_NEAREST);
  return result;
}

// Gradients, cut off at the strong ones, 0 to 1.
cv::Mat color_edges(const cv::Mat& rgb) {
  cv::Mat gray, dx, dy, strength;
  cv::cvtColor(rgb, gray, cv::COLOR_BGR2GRAY);
  const int step = thinning(gray.size());
  if (step > 1) cv::resize(gray, gray, gray.size() / step, 0, 0, cv::INTER_AREA);
  cv::Sobel(gray, dx, CV_32F, 1, 0);
  cv::Sobel(gray, dy, CV_32F, 0, 1);
  cv::magnitude(dx, dy, strength);
  std::vector<float> values(strength.begin<float>(), strength.end<float>());
  std::nth_element(values.begin(), values.begin() + std::ssize(values) * 9 / 10, values.end());
  const float strong = std::max(20.0F, values[values.size() * 9 / 10]);
  strength = cv::min(strength / strong, 1.0F);
  cv::GaussianBlur(strength, strength, cv::Size(3, 3), 0.8);
  return strength;
}

// The nearer side of jumps between neighbours along rows and columns, holes passed over.
Points depth_edges(const cv::Mat& full) {
  const cv::Mat depth = thinned_out(full);
  Points points;
  const auto walk = [&](int lines, int length, const auto& at) {
    for (int line = 0; line < lines; ++line) {
      int last = -1;
      for (int i = 0; i < length; ++i) {
        const float z = depth.at<float>(at(line, i));
        if (!(z > 0)) continue;
        const float before = last >= 0 ? depth.at<float>(at(line, last)) : 0;
        if (last >= 0 && i - last <= kHole_px + 1 && std::abs(z - before) > kJump * std::min(z, before))
          points.push_back(z < before ? at(line, i) : at(line, last));
        last = i;
      }
    }
  };
  walk(depth.rows, depth.cols, [](int line, int i) { return cv::Point(i, line); });
  walk(depth.cols, depth.rows, [](int line, int i) { return cv::Point(line, i); });
  return points;
}

Points mask_edges(const cv::Mat& full) {
  const cv::Mat masks = thinned_out(full);
  Points points;
  for (int v = 1; v < masks.rows; ++v)
    for (int u = 1; u < masks.cols; ++u) {
      const auto id = masks.at<std::uint16_t>(v, u);
      if (id != masks.at<std::uint16_t>(v, u - 1) || id != masks.at<std::uint16_t>(v - 1, u))
        points.emplace_back(u, v);
    }
  return points;
}

using Place = std::function<cv::Point(cv::Point)>;

// Mean strength of colour's edges at the places; the surroundings' mean where they lie outside.
double strength_at(const cv::Mat& edges, const Points& points, const Place& place) {
  double sum = 0;
  std::size_t count = 0;
  for (const cv::Point& point : points) {
    const cv::Point p = place(point);
    if (p.x < 0 || p.y < 0 || p.x >= edges.cols || p.y >= edges.rows) continue;
    sum += edges.at<float>(p);
    ++count;
  }
  return count > 0 ? sum / static_cast<double>(count) : 0;
}

// Of one alignment, in each frame.
struct Score {
  std::string cause;
  std::vector<double> frames;
  double mean() const {
    double sum = 0;
    for (const double value : frames) sum += value;
    return frames.empty() ? 0 : sum / static_cast<double>(frames.size());
  }
};

struct Frame {
  cv::Mat colors;
  Points edges;
  std::vector<Points> others;  // of the frames kMostLate before to kMostLate after; empty: none
};

Score score(const std::vector<Frame>& frames, const std::string& cause, const Place& place) {
  Score result{cause, {}};
  for (const Frame& frame : frames) result.frames.push_back(strength_at(frame.colors, frame.edges, place));
  return result;
}

Place shifted(int dx, int dy) {
  return [dx, dy](cv::Point p) { return cv::Point(p.x + dx, p.y + dy); };
}

// Of shifts around none, the usual strength: what edges that know nothing of colour have.
double usual_strength(const std::vector<Frame>& frames) {
  double sum = 0;
  int count = 0;
  for (int dy = -kReach_px; dy <= kReach_px; dy += 5)
    for (int dx = -kReach_px; dx <= kReach_px; dx += 5)
      if (std::max(std::abs(dx), std::abs(dy)) >= 5)
        sum += score(frames, "", shifted(dx, dy)).mean(), ++count;
  return sum / count;
}

Score as_it_is(const std::vector<Frame>& frames) {
  Score best = score(frames, "", shifted(0, 0));
  for (int dy = -kSameShift_px; dy <= kSameShift_px; ++dy)
    for (int dx = -kSameShift_px; dx <= kSameShift_px; ++dx)
      if (const Score other = score(frames, "", shifted(dx, dy)); other.mean() > best.mean()) best = other;
  return best;
}

std::vector<Score> other_alignments(const std::vector<Frame>& frames) {
  const int w = frames.front().colors.cols - 1, h = frames.front().colors.rows - 1;
  std::vector<Score> list;
  list.push_back(
      score(frames, "mirrored left to right", [w](cv::Point p) { return cv::Point(w - p.x, p.y); }));
  list.push_back(score(frames, "upside down", [h](cv::Point p) { return cv::Point(p.x, h - p.y); }));
  list.push_back(
      score(frames, "turned by 180 degrees", [w, h](cv::Point p) { return cv::Point(w - p.x, h - p.y); }));
  for (int dy = -kReach_px; dy <= kReach_px; ++dy)
    for (int dx = -kReach_px; dx <= kReach_px; ++dx)
      if (std::max(std::abs(dx), std::abs(dy)) > kSameShift_px)
        list.push_back(
            score(frames,
                  fmt::format("not registered to colour: shifted by about {}, {} px of {}", -dx, -dy, w + 1),
                  shifted(dx, dy)));
  return list;
}

// The same frames' colour against the edges of frames k later.
std::vector<Score> other_frames(const std::vector<Frame>& frames, double usual) {
  std::vector<Score> list;
  for (int k = -kMostLate; k <= kMostLate; ++k) {
    if (k == 0) continue;
    Score result{
        fmt::format("{} by {} frame{}", k > 0 ? "late" : "early", std::abs(k), std::abs(k) > 1 ? "s" : ""),
        {}};
    std::size_t missing = 0;
    for (const Frame& frame : frames) {
      const Points& edges = frame.others[k + kMostLate];
      missing += edges.empty();
      result.frames.push_back(edges.empty() ? usual : strength_at(frame.colors, edges, shifted(0, 0)));
    }
    if (missing == 0) list.push_back(std::move(result));
  }
  return list;
}

bool agrees(const Score& better, const Score& as_is) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < better.frames.size(); ++i) count += better.frames[i] > as_is.frames[i];
  return static_cast<double>(count) >= kMostFrames * static_cast<double>(better.frames.size());
}

std::optional<std::string> judged(const std::vector<Frame>& frames, const Clarity& clarity) {
  if (frames.size() < kLeastFrames) return std::nullopt;
  const double usual = usual_strength(frames);
  const Score as_is = as_it_is(frames);
  std::optional<std::string> cause;
  double best = std::max(clarity.better * (as_is.mean() - usual), clarity.contrast);
  const auto look = [&](const Score& other) {
    if (other.mean() - usual <= best || !agrees(other, as_is)) return;
    best = other.mean() - usual;
    cause = other.cause;
  };
  for (const Score& other : other_alignments(frames)) look(other);
  for (const Score& other : other_frames(frames, usual)) look(other);
  return cause;
}

using Edges = std::function<Points(const SequenceFrame&)>;

std::vector<Frame> chosen_frames(const Sequence& sequence, int wanted, const Edges& edges_of) {
  std::vector<Frame> frames;
  const int count = static_cast<int>(sequence.frames.size());
  const int from = std::min(kMostLate, count / 4), span = count - 2 * from;
  for (int i = 0; i < std::min(wanted, span); ++i) {
    const int at = from + i * span / std::min(wanted, span);
    Frame frame;
    frame.edges = edges_of(sequence.frames[at]);
    if (frame.edges.size() < kLeastEdges) continue;
    frame.colors = color_edges(read_rgb(sequence, sequence.frames[at]));
    for (int k = -kMostLate; k <= kMostLate; ++k) {
      const int other = at + k;
      frame.others.push_back(k != 0 && other >= 0 && other < count ? edges_of(sequence.frames[other])
                                                                   : Points());
    }
    frames.push_back(std::move(frame));
  }
  return frames;
}

}  // namespace

std::vector<std::string> edge_suspicions(const Sequence& sequence, EdgesOf what, int frames) {
  const bool is_depth = what == EdgesOf::depth;
  const Edges edges_of = [&](const SequenceFrame& frame) {
    if ((is_depth ? frame.depth : frame.masks).empty()) return Points();
    return is_depth ? depth_edges(read_depth(sequence, frame)) : mask_edges(read_masks(sequence, frame));
  };
  try {
    const auto cause = judged(chosen_frames(sequence, frames, edges_of), is_depth ? kOfDepth : kOfMasks);
    if (!cause) return {};
    return {fmt::format("{}: {} {} (by edges, against those of colour)",
                        (sequence.folder / (is_depth ? "depth.txt" : "masks.txt")).string(),
                        is_depth ? "depth looks" : "masks look", *cause)};
  } catch (const InputError&) {  // is told by who reads all images
    return {};
  }
}

}  // namespace uniquadric
