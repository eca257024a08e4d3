#include "estimator/perception/segmentation.h"

#include <algorithm>
#include <map>

#include "core/base/error.h"

namespace uniquadric {
namespace {

constexpr double kMinPromptIou =
    0.3;  // of a box with a mask's bounding box: half of one that is shifted by half fits

MaskSource resolve(const Sequence& sequence, MaskSource source, bool has_prompts) {
  const bool has_masks = std::any_of(sequence.frames.begin(), sequence.frames.end(),
                                     [](const auto& frame) { return !frame.masks.empty(); });
  if (source == MaskSource::automatic) source = has_masks ? MaskSource::sequence : MaskSource::grabcut_depth;
  if (source == MaskSource::sequence && !has_masks)
    throw InputError(sequence.folder, "has no masks, which the variant's segmentation asks for");
  if (source == MaskSource::grabcut_depth && !has_prompts)
    throw InputError(sequence.folder,
                     "needs box prompts (a folder of STAMP.txt or a file), for it has no masks to use");
  return source;
}

std::map<int, BoxPrompt> bounding_boxes(const cv::Mat& masks) {
  std::map<int, BoxPrompt> boxes;
  for (int v = 0; v < masks.rows; ++v)
    for (int u = 0; u < masks.cols; ++u) {
      const int id = masks.at<std::uint16_t>(v, u);
      if (id == 0) continue;
      const auto [entry, is_new] = boxes.try_emplace(id, BoxPrompt{id, u - 0.5, v - 0.5, 1, 1});
      BoxPrompt& box = entry->second;
      const double right = std::max(box.x + box.width, u + 0.5);
      box.x = std::min(box.x, u - 0.5);
      box.width = right - box.x;
      box.height = v + 0.5 - box.y;
    }
  return boxes;
}

std::set<int> ids_meant(const Sequence& sequence, const std::vector<std::vector<BoxPrompt>>& prompts) {
  std::set<int> ids;
  for (const auto& frame : sequence.frames) {
    if (frame.masks.empty() || prompts[frame.frame].empty()) continue;
    const auto boxes = bounding_boxes(read_masks(sequence, frame));
    for (const auto& prompt : prompts[frame.frame]) {
      const auto best = std::max_element(boxes.begin(), boxes.end(), [&](const auto& a, const auto& b) {
        return box_iou(a.second, prompt) < box_iou(b.second, prompt);
      });
      if (best != boxes.end() && box_iou(best->second, prompt) >= kMinPromptIou) ids.insert(best->first);
    }
  }
  return ids;
}

cv::Mat keep_selected(cv::Mat masks, const std::set<int>& selected) {
  for (auto& id : cv::Mat_<std::uint16_t>(masks))
    if (!selected.contains(id)) id = 0;
  return masks;
}

// Where two objects claim a pixel the smaller box has it: it is more likely the one in front.
cv::Mat masks_of_boxes(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                       const cv::Mat& rgb, const cv::Mat& depth, std::uint64_t seed) {
  auto boxes = segmenter.prompts[frame.frame];
  if (boxes.empty()) return {};
  std::stable_sort(boxes.begin(), boxes.end(),
                   [](const auto& a, const auto& b) { return a.width * a.height > b.width * b.height; });
  cv::Mat masks = cv::Mat::zeros(rgb.size(), CV_16UC1);
  for (const auto& box : boxes) {
    RandomStream random(seed, "grabcut_depth", frame.frame, box.id);
    masks.setTo(box.id, grabcut_depth(rgb, depth, sequence.camera, box, segmenter.grabcut_depth, random));
  }
  return masks;
}

}  // namespace

Segmenter make_segmenter(const Sequence& sequence, const SegmentationOptions& options,
                         const std::filesystem::path& prompts) {
  Segmenter segmenter;
  segmenter.source = resolve(sequence, options.source, !prompts.empty());
  segmenter.grabcut_depth = options.grabcut_depth;
  if (prompts.empty()) return segmenter;
  segmenter.prompts = read_box_prompts(prompts, sequence);
  if (segmenter.source != MaskSource::sequence) return segmenter;
  segmenter.selected = ids_meant(sequence, segmenter.prompts);
  if (segmenter.selected->empty()) throw InputError(prompts, "no box fits a mask of the sequence");
  return segmenter;
}

cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& rgb, const cv::Mat& depth, std::uint64_t seed) {
  if (segmenter.source == MaskSource::grabcut_depth)
    return masks_of_boxes(segmenter, sequence, frame, rgb, depth, seed);
  if (frame.masks.empty()) return {};
  cv::Mat masks = read_masks(sequence, frame);
  return segmenter.selected ? keep_selected(std::move(masks), *segmenter.selected) : masks;
}

cv::Mat segment(const Segmenter& segmenter, const Sequence& sequence, const SequenceFrame& frame,
                const cv::Mat& depth, std::uint64_t seed) {
  const bool needs_rgb =
      segmenter.source == MaskSource::grabcut_depth && !segmenter.prompts[frame.frame].empty();
  return segment(segmenter, sequence, frame, needs_rgb ? read_rgb(sequence, frame) : cv::Mat(), depth, seed);
}

}  // namespace uniquadric
