#pragma once

#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

enum class EdgesOf { depth, masks };

/// Whether edges of depth, or of masks, lie on edges of colour, or where they lie better: mirrored, turned,
/// shifted, or on the colour of another frame. One sentence, or nothing.
std::vector<std::string> edge_suspicions(const Sequence& sequence, EdgesOf what, int frames);

}  // namespace uniquadric
