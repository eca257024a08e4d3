#pragma once

#include <optional>
#include <string>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// What is wrong with a sequence's depth scale: the median depth of up to five of its depth images, evenly
/// spaced, lies beyond 100 m or below 1 cm, which no depth camera measures. Nothing where there is no depth;
/// images that cannot be read are left to who reads them all.
std::optional<std::string> depth_scale_fault(const Sequence& sequence);

}  // namespace uniquadric
