#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/sequence/tracks.h"

namespace uniquadric {

/// What of an estimate's stamps does not fit the truth's frames (the stamps of its camera's poses), a line a
/// fault, each naming its file: a camera of fewer than kMinPairs poses; stamps further than
/// `max_difference_ns` from every frame, or beside a nearer one, which are not compared; stamps beside the
/// frames that they are compared with (another clock, half a frame). With `same_frames`, rows of objects.csv
/// whose frame is not the truth's at their stamp too. Empty: all fit.
std::vector<std::string> stamp_faults(const std::filesystem::path& estimate_folder, const Tracks& truth,
                                      const Tracks& estimate, std::int64_t max_difference_ns,
                                      bool same_frames);

}  // namespace uniquadric
