#pragma once

#include <cstdint>
#include <vector>

#include "core/sequence/tracks.h"
#include "estimator/backend.h"
#include "estimator/variant.h"

namespace uniquadric {

/// The paper's baseline: Alg. 1 on the depth points of each frame by itself. The variance of the semi-axes is
/// Alg. 1's uncertainty squared; pose variances are not estimated.
BackendResult estimate_single_frames(const Perception& perception, const Variant& variant,
                                     std::uint64_t seed);

}  // namespace uniquadric
