#pragma once

#include <cstdint>

#include "core/sequence/sequence.h"
#include "estimator/ego/depth_calibration.h"
#include "estimator/ego/rgbd_odometry.h"
#include "estimator/perception/features.h"

namespace uniquadric {

/// The bias of a sequence's depth images, as of a calibration before it is used: by the first seconds of its
/// background, as many as it takes to know the bias well. No bias where they do not say, or without depth
/// images.
DepthBias depth_bias(const Sequence& sequence, FeatureOptions features, const EgoOptions& ego,
                     std::uint64_t seed);

}  // namespace uniquadric
