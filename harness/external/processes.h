#pragma once

#include <vector>

namespace uniquadric {

/// All processes below `root` in the tree of parents and children, as /proc shows them; not `root` itself.
std::vector<int> descendants(int root);

/// Memory that the processes hold together [bytes]: what each has for itself, and the largest part that one
/// of them shares (libraries and shared memory count once).
double resident_bytes(const std::vector<int>& processes);

}  // namespace uniquadric
