#pragma once

#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// Whether edges of depth, and of masks, lie on edges of colour, and where they lie better: mirrored, turned,
/// shifted, or on the colour of another frame. One sentence for each of both that does not fit.
std::vector<std::string> edge_suspicions(const Sequence& sequence, int frames);

}  // namespace uniquadric
