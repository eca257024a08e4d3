#pragma once

#include <string>
#include <vector>

#include "core/sequence/sequence.h"

namespace uniquadric {

/// Stamps that no sensor has: frame rates in another unit, clocks that share no time.
std::vector<std::string> stamp_suspicions(const Sequence& sequence);

}  // namespace uniquadric
