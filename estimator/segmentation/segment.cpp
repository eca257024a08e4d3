// segment(): what each source does with a frame.
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <set>

#include "estimator/observation/outline.h"
#include "estimator/segmentation/moving_parts.h"
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
int free_label(const Segmenter& segmenter, int id, std::set<int>& taken) {
  int label = segmenter.names_bodies ? id : std::numeric_limits<std::uint16_t>::max();
  while (taken.contains(label)) --label;
  taken.insert(label);
  return label;
}

// The user's boxes of a frame, and boxes of the tracked bodies that they leave out.
std::vector<BoxPrompt> boxes_of(const Segmenter& segmenter, const SegmenterInput& input) {
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
std::vector<PointPrompt> points_of(const Segmenter& segmenter, const SegmenterInput& input) {
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
cv::Mat checked(const Segmenter& segmenter, const SequenceFrame& frame, cv::Mat masks) {
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

// Where two objects claim a pixel the smaller box has it: it is more likely the one in front.
cv::Mat masks_of_boxes(std::vector<BoxPrompt> boxes, const GrabcutOptions& options, const Camera& camera,
                       const SegmenterInput& input, std::uint64_t seed) {
  if (boxes.empty() || input.depth.empty()) return {};
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const auto& a, const auto& b) { return a.width * a.height > b.width * b.height; });
  cv::Mat masks = cv::Mat::zeros(input.rgb.size(), CV_16UC1);
  for (const auto& box : boxes) {
    RandomStream random(seed, "grabcut_depth", input.frame.frame, box.id);
    masks.setTo(box.id, grabcut_depth(input.rgb, input.depth, camera, box, options, random));
  }
  return masks;
}

// The images some frames earlier that a frame's motions are seen against, each read once.
class EarlierImages {
 public:
  EarlierImages(const Sequence& sequence, const SegmenterInput& input) : sequence_(sequence), input_(input) {}

  // Nothing at the start and where there is no depth.
  const std::optional<EarlierImage>& before(int frames) {
    const auto [entry, is_new] = images_.try_emplace(frames);
    if (is_new) entry->second = read(frames);
    return entry->second;
  }

 private:
  std::optional<EarlierImage> read(int frames) const {
    if (input_.frame.frame < frames) return std::nullopt;
    const SequenceFrame& earlier = sequence_.frames[input_.frame.frame - frames];
    if (earlier.depth.empty()) return std::nullopt;
    return with_flow({read_rgb(sequence_, earlier), read_depth(sequence_, earlier)},
                     {input_.rgb, input_.depth});
  }

  const Sequence& sequence_;
  const SegmenterInput& input_;
  std::map<int, std::optional<EarlierImage>> images_;
};

// The parts that are seen to move twice: once may be an error of the flow. Over as long as the background's
// motion is known: a fast turn leaves less time.
cv::Mat parts_that_move(const cv::Mat& parts, const Camera& camera, const MotionSplitOptions& options,
                        const SegmenterInput& input, EarlierImages& earlier) {
  const auto moving = [&](const cv::Mat& of, int frames) -> std::optional<cv::Mat> {
    const auto& before = earlier.before(frames);
    if (!before) return std::nullopt;
    return moving_parts(of, {input.rgb, input.depth}, *before, input.tracked, camera, options);
  };
  for (int frames = 2 * options.frames; frames > 1; frames /= 2)
    if (const auto once = moving(parts, frames)) {
      frames /= 2;
      if (const auto twice = moving(*once, frames)) return *twice;
    }
  return cv::Mat::zeros(parts.size(), CV_16UC1);
}

cv::Mat masks_by_depth_and_motion(const Segmenter& segmenter, const Sequence& sequence,
                                  const SegmenterInput& input, std::uint64_t seed) {
  if (input.depth.empty()) return {};
  RandomStream random(seed, "depth_motion", input.frame.frame);
  const Camera& camera = sequence.camera;
  const MotionSplitOptions& motion = segmenter.options.motion_split;
  EarlierImages earlier(sequence, input);
  cv::Mat parts = depth_parts(input.depth, camera, segmenter.options.depth_parts, random);
  if (const auto& before = earlier.before(motion.frames))
    parts = split_by_motion(parts, {input.rgb, input.depth}, *before, camera, motion, random);
  if (segmenter.prompt_kind == PromptKind::points) return parts_at_points(parts, points_of(segmenter, input));
  return motion.moving_ratio > 0 ? parts_that_move(parts, camera, motion, input, earlier) : parts;
}

cv::Mat masks_by_sam(const Segmenter& segmenter, const SegmenterInput& input) {
  if (segmenter.prompt_kind == PromptKind::everything) return segmenter.sam->segment_everything(input.rgb);
  std::vector<SamPrompt> prompts;
  if (segmenter.prompt_kind == PromptKind::boxes)
    for (const auto& box : boxes_of(segmenter, input)) prompts.push_back({box.id, {}, {box}});
  std::map<int, SamPrompt> by_id;
  if (segmenter.prompt_kind == PromptKind::points)
    for (const auto& point : points_of(segmenter, input)) by_id[point.id].points.push_back(point);
  for (auto& [id, prompt] : by_id) {
    prompt.id = id;
    prompts.push_back(std::move(prompt));
  }
  return segmenter.sam->segment(input.rgb, prompts);
}

}  // namespace

cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SegmenterInput& input,
                std::uint64_t seed) {
  const Camera& camera = sequence.camera;
  const auto& options = segmenter.options;
  switch (segmenter.source) {
    case MaskSource::automatic:
    case MaskSource::sequence:
      break;
    case MaskSource::none:
      return cv::Mat::zeros(camera.height, camera.width, CV_16UC1);
    case MaskSource::grabcut_depth:
      return checked(segmenter, input.frame,
                     masks_of_boxes(boxes_of(segmenter, input), options.grabcut_depth, camera, input, seed));
    case MaskSource::depth_motion:
      return checked(segmenter, input.frame, masks_by_depth_and_motion(segmenter, sequence, input, seed));
    case MaskSource::sam:
      return checked(segmenter, input.frame, masks_by_sam(segmenter, input));
    case MaskSource::detector:
      return masks_of_boxes(detect_boxes(*segmenter.detector, input.rgb, options.detector),
                            options.grabcut_depth, camera, input, seed);
  }
  if (input.frame.masks.empty()) return {};
  cv::Mat masks = read_masks(sequence, input.frame);
  return segmenter.selected ? keep_selected(std::move(masks), *segmenter.selected) : masks;
}

cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed) {
  if (!has_something_for(segmenter, frame)) return {};
  const bool needs_colours = segmenter.source != MaskSource::sequence && segmenter.source != MaskSource::none;
  const cv::Mat rgb = needs_colours ? read_rgb(sequence, frame) : cv::Mat();
  return segment(segmenter, sequence, {frame, rgb, depth, {}}, seed);
}

}  // namespace uniquadric
