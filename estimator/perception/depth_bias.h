#pragma once

#include <optional>

#include "core/sequence/sequence.h"
#include "estimator/ego/depth_calibration.h"
#include "estimator/perception/perceive.h"

namespace uniquadric {

/// The bias of a sequence's depth images, as of a calibration before it is used: by the first seconds of its
/// background, as many as it takes to know the bias well. `has_masks`: whether the sequence's masks may be
/// used to tell what is background; without, it is what most moves alike. Nothing where too few frames have
/// depth.
std::optional<DepthBias> depth_bias(const Sequence& sequence, const PerceptionOptions& options,
                                    bool has_masks, const PerceiveOptions& run);

/// The width [px] of the ramps that a sequence's depth images make of steps, by some images of its first
/// seconds (smeared_edges.h); 1 where steps are sharp, or too few.
double depth_edge_width_px(const Sequence& sequence);

}  // namespace uniquadric
