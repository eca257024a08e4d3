// The segmenters that there are. A new one is a file, and two lines here.
#include <algorithm>
#include <cassert>

#include "estimator/segmentation/segmenter.h"

namespace uniquadric {

SegmenterKind sequence_kind();
SegmenterKind grabcut_kind();
SegmenterKind depth_motion_kind();
SegmenterKind sam_kind();
SegmenterKind detector_kind();
SegmenterKind no_masks_kind();

const std::vector<SegmenterKind>& segmenter_kinds() {
  static const std::vector<SegmenterKind> kinds = {sequence_kind(), grabcut_kind(),  depth_motion_kind(),
                                                   sam_kind(),      detector_kind(), no_masks_kind()};
  return kinds;
}

const SegmenterKind& segmenter_kind_of(const std::string& name) {
  const auto& kinds = segmenter_kinds();
  const auto kind = std::ranges::find(kinds, name, &SegmenterKind::name);
  assert(kind != kinds.end());
  return *kind;
}

namespace {

Choices<std::string> sources() {
  Choices<std::string> choices = {{"automatic", "automatic"}};
  for (const SegmenterKind& kind : segmenter_kinds()) choices.emplace_back(kind.name.c_str(), kind.name);
  return choices;
}

std::any& options_of(SegmentationOptions& options, const SegmenterKind& kind) {
  return options.options.try_emplace(kind.name, kind.options).first->second;
}

}  // namespace

void visit(OptionReader& io, SegmentationOptions& options) {
  io.choice("source", options.source, sources());
  for (const SegmenterKind& kind : segmenter_kinds()) kind.read(io, options_of(options, kind));
}

void visit(OptionWriter& io, SegmentationOptions& options) {
  io.choice("source", options.source, sources());
  for (const SegmenterKind& kind : segmenter_kinds()) kind.write(io, options_of(options, kind));
}

}  // namespace uniquadric
