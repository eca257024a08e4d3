#pragma once

namespace uniquadric {

/// Called in a process that was just forked: it is killed when its parent ends, also when that has happened
/// already. `parent`: process id before the fork. Async-signal-safe.
void end_with_parent(int parent);

}  // namespace uniquadric
