#pragma once

#include <vector>

#include "evaluation/association/stamps.h"

namespace uniquadric {

/// Pairs as evo chooses them from stamps in any order, equal ones too [s]: each pose of the shorter list, in
/// its order, with the first of the other's nearest, at most `max_difference_s` away. Differences are those
/// of doubles. Of lists of equal length the estimate counts as the shorter.
std::vector<IndexPair> associate_as_evo(const std::vector<double>& reference_s,
                                        const std::vector<double>& estimate_s, double max_difference_s);

}  // namespace uniquadric
