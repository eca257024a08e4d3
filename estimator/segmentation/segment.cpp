// segment(): the prompts of a frame, and which of them led to masks.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <set>

#include "estimator/observation/outline.h"
#include "estimator/segmentation/segmentation.h"

namespace uniquadric {
namespace {

constexpr double kSameBody = 0.3;   // IoU of a prompt's box with a tracked one's
constexpr double kBoxMargin = 0.1;  // of a tracked body's box, by which it is enlarged: the body moved on

cv::Mat keep_selected(cv::Mat masks, const std::set<int>& selected) {
  for (auto& id : cv::Mat_<std::uint16_t>(masks))
    if (!selected.contains(id)) id = 0;
  return masks;
}

// A label that no other prompt of the frame has, the tracked body's own id if that is a prompt's.
int free_label(const PromptedSegmenter& segmenter, int id, std::set<int>& taken) {
  int label = segmenter.names_bodies ? id : std::numeric_limits<std::uint16_t>::max();
  while (taken.contains(label)) --label;
  taken.insert(label);
  return label;
}

// The user's boxes of a frame, and boxes of the tracked bodies that they leave out.
std::vector<BoxPrompt> boxes_of(const PromptedSegmenter& segmenter, const SegmenterInput& input) {
  std::vector<BoxPrompt> boxes = segmenter.boxes[input.frame.frame];
  if (input.tracked.empty()) return boxes;
  const std::vector<BoxPrompt> given = boxes;
  std::set<int> labels;
  for (const auto& box : given) labels.insert(box.id);
  for (const auto& [id, rect] : id_boxes(input.tracked)) {
    const double dx = kBoxMargin * rect.width, dy = kBoxMargin * rect.height;
    const BoxPrompt box{0, rect.x - 0.5 - dx, rect.y - 0.5 - dy, rect.width + 2 * dx, rect.height + 2 * dy};
    const auto is_given = [&](const BoxPrompt& other) { return box_iou(box, other) > kSameBody; };
    if (std::any_of(given.begin(), given.end(), is_given)) continue;
    if (segmenter.names_bodies && labels.contains(id)) continue;
    boxes.push_back(box);
    boxes.back().id = free_label(segmenter, id, labels);
  }
  return boxes;
}

// The pixel of a mask that is farthest from its outline.
cv::Point innermost(const cv::Mat& mask) {
  cv::Mat framed, distance;
  cv::copyMakeBorder(mask, framed, 1, 1, 1, 1, cv::BORDER_CONSTANT, cv::Scalar(0));
  cv::distanceTransform(framed, distance, cv::DIST_L2, 3);
  cv::Point place;
  cv::minMaxLoc(distance, nullptr, nullptr, nullptr, &place);
  return place - cv::Point(1, 1);
}

// The user's points of a frame, and a point in each tracked body that has none.
std::vector<PointPrompt> points_of(const PromptedSegmenter& segmenter, const SegmenterInput& input) {
  std::vector<PointPrompt> points = segmenter.points[input.frame.frame];
  if (input.tracked.empty()) return points;
  std::set<int> labels, pointed_at;
  for (const auto& point : points) {
    labels.insert(point.id);
    pointed_at.insert(input.tracked.at<std::uint16_t>(static_cast<int>(std::lround(point.v)),
                                                      static_cast<int>(std::lround(point.u))));
  }
  for (const auto& [id, box] : id_boxes(input.tracked)) {
    if (pointed_at.contains(id) || (segmenter.names_bodies && labels.contains(id))) continue;
    const cv::Point place = innermost(input.tracked(box) == id) + box.tl();
    points.push_back(
        {free_label(segmenter, id, labels), static_cast<double>(place.x), static_cast<double>(place.y)});
  }
  return points;
}

// The masks. Notes which of the user's prompts gave one, and says which points share one.
cv::Mat checked(const PromptedSegmenter& segmenter, const SequenceFrame& frame, cv::Mat masks) {
  if (!segmenter.watch || masks.empty()) return masks;
  const auto boxes = id_boxes(masks);
  const auto note = [&](int id) {
    if (boxes.contains(id)) segmenter.watch->found(frame.stamp_ns, id);
  };
  if (!segmenter.boxes.empty())
    for (const BoxPrompt& box : segmenter.boxes[frame.frame]) note(box.id);
  if (segmenter.points.empty()) return masks;
  const std::vector<PointPrompt>& points = segmenter.points[frame.frame];
  for (const PointPrompt& point : points) note(point.id);
  for (const auto& [first, second] : points_on_one_mask(masks, points))
    segmenter.watch->share({frame.stamp_ns, first}, {frame.stamp_ns, second});
  return masks;
}

FramePrompts prompts_of(const PromptedSegmenter& segmenter, const SegmenterInput& input) {
  FramePrompts prompts{segmenter.prompt_kind, {}, {}};
  if (prompts.kind == PromptKind::boxes) prompts.boxes = boxes_of(segmenter, input);
  if (prompts.kind == PromptKind::points) prompts.points = points_of(segmenter, input);
  return prompts;
}

}  // namespace

cv::Mat segment(const PromptedSegmenter& segmenter, const Sequence& sequence, const SegmenterInput& input,
                std::uint64_t seed) {
  if (segmenter.source == kSequenceMasks) {
    cv::Mat masks = segmenter.segmenter->segment(sequence, input, {}, seed);
    return segmenter.selected && !masks.empty() ? keep_selected(std::move(masks), *segmenter.selected)
                                                : masks;
  }
  return checked(segmenter, input.frame,
                 segmenter.segmenter->segment(sequence, input, prompts_of(segmenter, input), seed));
}

cv::Mat segment(const PromptedSegmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed) {
  if (!has_something_for(segmenter, frame)) return {};
  const bool needs_colours = segmenter.source != kSequenceMasks && segmenter.source != kNoMasks;
  const cv::Mat rgb = needs_colours ? read_rgb(sequence, frame) : cv::Mat();
  return segment(segmenter, sequence, {frame, rgb, depth, {}}, seed);
}

}  // namespace uniquadric
