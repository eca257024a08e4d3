#include "estimator/segmentation/segmentation.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/error.h"
#include "core/base/warning.h"
#include "estimator/observation/outline.h"

namespace uniquadric {
namespace {

constexpr double kMinPromptIou =
    0.3;  // of a box with a mask's bounding box: half of one that is shifted by half fits

bool has_any_masks(const Sequence& sequence) {
  return std::any_of(sequence.frames.begin(), sequence.frames.end(),
                     [](const auto& frame) { return !frame.masks.empty(); });
}

// Masks that no list names are as good as none, and another segmenter gives other results.
void warn_of_lost_masks(const Sequence& sequence, const char* instead) {
  const std::filesystem::path list = sequence.folder / "masks.txt";
  if (std::filesystem::is_directory(sequence.folder / "masks"))
    warn(fmt::format(
        "{}: is not there or names no masks: the images in masks/ are not used, bodies are segmented by {}",
        list.string(), instead));
}

std::string resolve(const Sequence& sequence, const std::string& source, PromptKind prompts) {
  if (source == "automatic") {
    if (has_any_masks(sequence)) return kSequenceMasks;
    const char* const instead = prompts == PromptKind::boxes ? "grabcut_depth" : "depth_motion";
    warn_of_lost_masks(sequence, instead);
    return instead;
  }
  if (source == kSequenceMasks && !has_any_masks(sequence))
    throw InputError(sequence.folder / "masks.txt",
                     "is not there or names no masks, which the variant's segmentation asks for");
  return source;
}

// What a segmenter takes, for messages.
std::string text_of(const std::set<PromptKind>& prompts) {
  std::vector<std::string> texts;
  if (prompts.contains(PromptKind::boxes))
    texts.emplace_back("box prompts (a folder of STAMP.txt or a file)");
  if (prompts.contains(PromptKind::points)) texts.emplace_back("point prompts");
  if (prompts.contains(PromptKind::everything)) texts.emplace_back(texts.empty() ? "no prompts" : "none");
  return fmt::format("{}", fmt::join(texts, " or "));
}

std::map<int, BoxPrompt> bounding_boxes(const cv::Mat& masks) {
  std::map<int, BoxPrompt> boxes;
  for (const auto& [id, box] : id_boxes(masks))
    boxes[id] = {id, box.x - 0.5, box.y - 0.5, static_cast<double>(box.width),
                 static_cast<double>(box.height)};
  return boxes;
}

void add_ids_of_boxes(const cv::Mat& masks, std::int64_t stamp_ns, const std::vector<BoxPrompt>& prompts,
                      PromptWatch& watch, std::set<int>& ids) {
  const auto boxes = bounding_boxes(masks);
  for (const auto& prompt : prompts) {
    const auto best = std::max_element(boxes.begin(), boxes.end(), [&](const auto& a, const auto& b) {
      return box_iou(a.second, prompt) < box_iou(b.second, prompt);
    });
    if (best == boxes.end() || box_iou(best->second, prompt) < kMinPromptIou) continue;
    ids.insert(best->first);
    watch.found(stamp_ns, prompt.id);
  }
}

// The first point on each mask so far, by the mask's id.
using FirstPoints = std::map<int, PromptWatch::Placed>;

void add_ids_of_points(const cv::Mat& masks, std::int64_t stamp_ns, const std::vector<PointPrompt>& prompts,
                       const PromptedSegmenter& segmenter, FirstPoints& first_on, std::set<int>& ids) {
  for (const auto& point : prompts) {
    const int id = masks.at<std::uint16_t>(static_cast<int>(std::lround(point.v)),
                                           static_cast<int>(std::lround(point.u)));
    if (id == 0) continue;
    ids.insert(id);
    segmenter.watch->found(stamp_ns, point.id);
    const auto& first = first_on.try_emplace(id, PromptWatch::Placed{stamp_ns, point}).first->second;
    if (first.point.id != point.id) segmenter.watch->share(first, {stamp_ns, point});
  }
}

std::set<int> ids_meant(const Sequence& sequence, const PromptedSegmenter& segmenter, bool ids_last) {
  std::set<int> ids;
  FirstPoints first_on;
  for (const auto& frame : sequence.frames) {
    if (frame.masks.empty()) continue;
    const bool has_boxes = !segmenter.boxes.empty() && !segmenter.boxes[frame.frame].empty();
    const bool has_points = !segmenter.points.empty() && !segmenter.points[frame.frame].empty();
    if (!has_boxes && !has_points) continue;
    const cv::Mat masks = read_masks(sequence, frame);
    if (has_boxes)
      add_ids_of_boxes(masks, frame.stamp_ns, segmenter.boxes[frame.frame], *segmenter.watch, ids);
    if (!ids_last) first_on.clear();  // a point of another frame may be of the same object
    if (has_points)
      add_ids_of_points(masks, frame.stamp_ns, segmenter.points[frame.frame], segmenter, first_on, ids);
  }
  return ids;
}

std::shared_ptr<PromptWatch> watch_for(const Sequence& sequence, const PromptedSegmenter& segmenter,
                                       const Prompts& prompts, bool ids_last) {
  auto watch = std::make_shared<PromptWatch>(prompts.path, ids_last);
  for (std::size_t frame = 0; frame < segmenter.boxes.size(); ++frame)
    for (const BoxPrompt& box : segmenter.boxes[frame])
      watch->expect(sequence.frames[frame].stamp_ns, box.id,
                    fmt::format("box ({:g}, {:g}, {:g}, {:g})", box.x, box.y, box.width, box.height));
  for (std::size_t frame = 0; frame < segmenter.points.size(); ++frame)
    for (const PointPrompt& point : segmenter.points[frame])
      watch->expect(sequence.frames[frame].stamp_ns, point.id,
                    fmt::format("point ({:g}, {:g})", point.u, point.v));
  return watch;
}

void read_prompts(const Sequence& sequence, const Prompts& prompts, PromptedSegmenter& segmenter) {
  segmenter.prompt_kind = prompts.kind;
  if (prompts.kind == PromptKind::boxes) segmenter.boxes = read_box_prompts(prompts.path, sequence);
  if (prompts.kind == PromptKind::points) segmenter.points = read_point_prompts(prompts.path, sequence);
  if (prompts.empty()) return;
  const bool ids_last = have_ids(prompts);
  segmenter.watch = watch_for(sequence, segmenter, prompts, ids_last);
  segmenter.names_bodies = segmenter.source != kSequenceMasks && ids_last;
  if (segmenter.source != kSequenceMasks) return;
  segmenter.selected = ids_meant(sequence, segmenter, ids_last);
  if (segmenter.selected->empty())
    throw InputError(prompts.path, fmt::format("no {} fits a mask of the sequence",
                                               prompts.kind == PromptKind::boxes ? "box" : "point"));
}

}  // namespace

PromptedSegmenter make_segmenter(const Sequence& sequence, const SegmentationOptions& options,
                                 const Prompts& prompts) {
  PromptedSegmenter segmenter;
  segmenter.source = resolve(sequence, options.source, prompts.kind);
  const SegmenterKind& kind = segmenter_kind_of(segmenter.source);
  if (!kind.prompts.contains(prompts.kind))
    throw InputError(prompts.empty() ? sequence.folder : prompts.path,
                     fmt::format("the variant's segmentation takes {}", text_of(kind.prompts)));
  read_prompts(sequence, prompts, segmenter);
  segmenter.segmenter = kind.make(options, prompts.kind);
  return segmenter;
}

void warn_of_prompts(const PromptedSegmenter& segmenter) {
  if (!segmenter.watch) return;
  for (const std::string& fault : segmenter.watch->faults()) warn(fault);
}

bool has_something_for(const PromptedSegmenter& segmenter, const SequenceFrame& frame) {
  if (segmenter.source == kSequenceMasks) return !frame.masks.empty();
  if (segmenter.prompt_kind == PromptKind::boxes) return !segmenter.boxes[frame.frame].empty();
  if (segmenter.prompt_kind == PromptKind::points) return !segmenter.points[frame.frame].empty();
  return true;
}

}  // namespace uniquadric
